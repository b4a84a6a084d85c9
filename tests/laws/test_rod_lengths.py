"""Lengths of rods whose ends are known: the distances, by formulas and by paths."""

from __future__ import annotations

import pytest

import symkin


@pytest.mark.parametrize("name", ["zhang2009", "zhao2000"])
def test_lengths_are_the_distances_of_the_ends(name):
    """One by one and together, by formulas and by paths: the same lengths, proved to be all."""
    machine = symkin.load(name)
    poses = [mode.pose for mode in symkin.modes(machine, joints=machine.example.joints)]
    together = symkin.modes(machine, pose=[tuple(p.position) + tuple(p.quaternion) for p in poses])
    for pose, batch in zip(poses, together, strict=True):
        alone = symkin.modes(machine, pose=pose)
        tracked = symkin.modes(machine, pose=pose, method="continuation")
        assert alone.completeness == batch.completeness == tracked.completeness
        assert len(alone) == len(batch) == len(tracked)
        for a, b, c in zip(alone, batch, tracked, strict=True):
            wanted = [float(v) for v in a.joints.values()]
            assert [float(v) for v in b.joints.values()] == pytest.approx(wanted, abs=1e-9)
            assert [float(v) for v in c.joints.values()] == pytest.approx(wanted, abs=1e-9)
            assert a.certified
