"""Colours of pictures and pages."""

COLOURS = {
    "text": "#1f2933",
    "quiet": "#52606d",
    "base": "#9aa5b1",
    "base edge": "#616e7c",
    "platform": "#2f7fc1",
    "platform edge": "#1b5a91",
    "link": "#3e4c59",
    "accent": "#e8743b",
    "loop": "#7a2ea0",
    "motion": "#8c2d9c",
    "slide": "#b8c2cc",
    "actuated slide": "#f6cdb5",
    "bar": "#9cc3e4",
    "pale": "#cfe0ee",
    "grid": "#dde3ea",
    "pane": "#fafbfc",
    "axis": "#9aa5b1",
}
LINK_COLOURS = (
    "#5b7a99",
    "#8a6d3b",
    "#6b8e4e",
    "#8e5572",
    "#4f8a8b",
    "#7a6fa8",
    "#a0614a",
    "#5f6b7a",
)
"""Of links other than the base and the platform's, in turn."""
SERIES = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#3e4c59", "#7a2ea0")
"""Colours of curves and groups in turn, which stay apart for all kinds of colour vision (Okabe and
Ito).
"""
KIND_COLOURS = dict(zip(("type 2", "type 1", "passive"), SERIES, strict=False))
"""Of singular curves, which stay apart for all kinds of colour vision."""
FRAME_COLOURS = ("#c0392b", "#2e8b57", "#2c5fa8")
"""Axes x, y, z of a frame."""
