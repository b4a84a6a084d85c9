"""Studies: published mechanisms computed anew, line by line; a folder a paper, `shared` for what
several use.

`SCRIPTS` names the file of each study by the name of what it writes.
"""

PAPERS = {
    name: f"{name}/study.py"
    for name in ("zhang2009", "zhao2000", "gluon_6l3", "ren2008", "yao2020")
}
"""The five papers."""
OTHERS = {
    "ren2008_planning": "ren2008/planning.py",
    "zhang2009_modes_map": "zhang2009/modes_map.py",
    "zhao2000_singular": "zhao2000/singular.py",
    "gluon_singular": "gluon_6l3/singular.py",
    **{
        name: f"others/{name}.py"
        for name in (
            "cusp_3rrr",
            "solvers",
            "coverage",
            "near_singular",
            "dietmaier1998",
            "general_6r",
            "hexapod_classes",
        )
    },
}
"""Further questions about their mechanisms, and further published mechanisms."""
SCRIPTS = PAPERS | OTHERS
