"""Options that a call would ignore are refused, on the command line and in Python; those that some
part reads are allowed.
"""

import numpy as np
import pytest

import symkin
from helpers.command_line import run
from helpers.inside import SOLVERS, Noise, Workspace, refuse_ignored
from helpers.samples import Z, parallel_rrr
from symkin import InputError, Joint, Limb, Measurements, Mechanism, plan_measurements

ARM_JOINTS = "0,0,0,0,0,0"
ARM_POSE = "0,0,400,1,0,0,0"
COMMANDS = [
    ("modes zhang2009 --starts 50", ["starts is", "multistart", "continuation"]),
    ("modes zhang2009 --method continuation --seed 3", ["seed is", "multistart"]),
    ("modes zhao2000 --starts 50 --seed 3", ["starts and seed are", "multistart"]),
    ("modes yao2020 --starts 50", ["starts is", "inverse problem"]),
    ("modes gluon_6l3 --starts 50", ["starts is", "a function of its joints"]),
    (
        f"solve gluon_6l3 --joints {ARM_JOINTS} --start {ARM_POSE}",
        ["start is", "a function of its joints"],
    ),
    (
        f"singularities gluon_6l3 --joints {ARM_JOINTS} --start {ARM_POSE}",
        ["start is", "a function of its joints"],
    ),
    ("singularities zhang2009 --range 0:1,0:1", ["--range is", "--plane"]),
    ("singularities zhang2009 --starts 3", ["--starts is", "--plane"]),
    ("singularities zhang2009 --seed 0", ["--seed is", "--plane"]),
    ("singularities zhang2009 --starts 9 --seed 0", ["--starts and --seed are", "--plane"]),
    ("singularities zhang2009 --plane x,y --output x", ["--output and --point", "--plane"]),
    (
        f"track gluon_6l3 --from {ARM_JOINTS} --to 1,1,1,1,1,1 --start {ARM_POSE}",
        ["start is", "a function of its joints"],
    ),
    ("sweep gluon_6l3 --grid q1=0:1:2 -o OUT --starts 9", ["starts is", "nothing is random"]),
    ("sweep gluon_6l3 --grid q1=0:1:2 -o OUT --seed 9", ["seed is", "nothing is random"]),
    (
        "sweep zhao2000 --grid theta1=0:1:2,theta2=1,theta3=2,op=100 --at 1,2,3,4 -o OUT",
        ["at is", "swept"],
    ),
    (
        "sweep zhao2000 --poses --grid x=0:1:2,y=1,z=2,gamma=3 --at 0,0,100,1,0,0,0 -o OUT",
        ["at is", "swept"],
    ),
    (
        "sweep zhao2000 --grid theta1=0:1:2,theta2=1:2:2 -o OUT --slice theta1=0",
        ["--slice", "--plot"],
    ),
    (
        "sweep zhao2000 --grid theta1=0:1:2,theta2=1:2:2 -o OUT --plot OUT.png --slice "
        "theta1=0,theta2=1",
        ["slice", "all that is swept"],
    ),
    (
        "sweep zhao2000 --grid theta1=0:1:2 -o OUT --workers 1 --dask tcp://127.0.0.1:1",
        ["workers and dask"],
    ),
    (
        "calibrate simulate ren2008 -o OUT --readings position --noise-inclination 1deg",
        ["--noise-inclination is", "--readings"],
    ),
    (
        "calibrate simulate ren2008 -o OUT --readings position --noise-orientation 1deg",
        ["--noise-orientation is", "--readings"],
    ),
    (
        "calibrate simulate ren2008 -o OUT --groups 5 --noise-position 1mm",
        ["--noise-position is", "--readings"],
    ),
    (
        "calibrate simulate ren2008 -o OUT --readings pose --noise-distance 1mm",
        ["--noise-distance is", "--distance"],
    ),
    (
        "calibrate simulate ren2008 -o OUT --readings pose --noise-group 1deg",
        ["--noise-group", "--groups"],
    ),
    (
        "calibrate simulate ren2008 -o OUT --readings position --euler ZYX",
        ["--euler is", "--readings"],
    ),
    (
        "calibrate simulate ren2008 -o OUT --readings pose --hide-sequence",
        ["--hide-sequence is", "--euler"],
    ),
    ("calibrate simulate ren2008 -o OUT --plan p.csv --postures 3", ["--postures is", "--plan"]),
    (
        "calibrate simulate ren2008 -o OUT --plan p.csv --groups 0 --box 1,1,1",
        ["--groups and --box are", "--plan"],
    ),
    (
        "calibrate simulate ren2008 -o OUT --plan p.csv --tilt 3deg --spin 3deg",
        ["--tilt and --spin are", "--plan"],
    ),
    (
        "calibrate simulate gluon_6l3 -o OUT --readings pose --box 1,1,1 --tilt 3deg",
        ["--box and --tilt are", "by its joints"],
    ),
    (
        "calibrate plan ren2008 -o OUT --groups 0 --readings pose --wedges 0:0",
        ["wedges is", "groups"],
    ),
    (
        "calibrate plan ren2008 -o OUT --noise-inclination 1deg",
        ["--noise-inclination is", "--readings"],
    ),
    (
        "calibrate plan ren2008 -o OUT --readings inclination --noise-orientation 1deg",
        ["--noise-orientation is", "--readings"],
    ),
    ("firmware gluon_6l3 -o OUT --home-relative", ["--home-relative", "six rods"]),
    ("firmware gluon_6l3 -o OUT --home 0,0,400,1,0,0,0", ["--home", "six rods"]),
]


def helix() -> Mechanism:
    left = Limb(
        "left",
        [Joint("a", "R", (0, 0, 0), Z, actuated=True), Joint("h", "H", (1, 0, 0), Z, pitch=0.3)],
    )
    right = Limb("right", [Joint("b", "R", (4, 0, 0), Z), Joint("s", "S", (2, 1, 0))])
    return Mechanism("helix", [left, right], platform_position=(2, 1, 0))


@pytest.mark.slow
@pytest.mark.parametrize(("command", "words"), COMMANDS, ids=[command for command, _ in COMMANDS])
def test_the_command_line_refuses_what_it_would_ignore(
    capsys, tmp_path, monkeypatch, command, words
) -> None:
    """Status 2, nothing on stdout, one line that names the options and says what to use, and no
    file.
    """
    monkeypatch.chdir(tmp_path)
    status, out, err = run(capsys, *command.split())
    assert (status, out) == (2, "")
    # a slow machine says how far it is
    lines = [line for line in err.strip().splitlines() if not line.endswith("s)")]
    assert len(lines) == 1
    assert all(word in lines[0] for word in words), err
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"starts": 100}, "starts is given.*continuation.*method = 'multistart'"),
        ({"seed": 0}, "seed is given.*method = 'multistart'"),
        ({"method": "continuation", "solver": "newton"}, "solver is given.*method = 'multistart'"),
        ({"method": "continuation", "solver": "batched"}, "solver is given.*method = 'multistart'"),
    ],
    ids=str,
)
def test_continuation_refuses_what_belongs_to_multistart(options, words) -> None:
    """In Python too; the same with multistart is read."""
    platform = symkin.load("zhao2000")
    with pytest.raises(InputError, match=words):
        symkin.modes(platform, **options)
    found = symkin.modes(platform, **{"starts": 60, **options, "method": "multistart"})
    assert found.starts == options.get("starts", 60)
    assert found.seed == options.get("seed", 0)


def test_a_solver_alone_means_multistart() -> None:
    found = symkin.modes(symkin.load("zhao2000"), solver="batched", starts=60)
    assert found.method == "multistart"
    assert found.starts == 60


@pytest.mark.slow
@pytest.mark.parametrize(
    "make",
    [helix, lambda: parallel_rrr("planar")],
    ids=["no start system", "a set that is not isolated"],
)
def test_continuation_reads_starts_where_a_part_is_sampled(make) -> None:
    """Where a helix has no start system, and where paths end on a set, `starts` and `seed` are read
    and allowed.
    """
    found = symkin.modes(make(), starts=40, seed=7)
    assert found.method == "continuation"
    assert found.seed == 7
    assert found.starts in (40, None)


def test_a_problem_without_a_real_solution_refuses_as_one_with_solutions() -> None:
    """Whether `starts` is refused does not depend on the given lengths; the least error needs
    none.
    """
    lengths = (100, 2000, 100, 100, 100, 100)
    platform = symkin.load("zhang2009")
    with pytest.raises(InputError, match="starts is given"):
        symkin.modes(platform, joints=lengths, starts=100)
    assert symkin.modes(platform, joints=lengths).smallest_residual > 100


def test_the_formula_of_an_arm_answers_every_method() -> None:
    """Forward kinematics: a method or a solver that is named is answered by the formula, which says
    so; a start is refused.
    """
    arm = symkin.load("gluon_6l3")
    assert symkin.modes(arm, method="multistart", starts=5).method == "forward"
    assert all(symkin.solve(arm, solver=solver).method == "forward" for solver in SOLVERS)
    with pytest.raises(InputError, match="start is given"):
        symkin.solve(arm, start=[0, 0, 400, 1, 0, 0, 0])
    with pytest.raises(InputError, match="start is given"):
        symkin.singularity(arm, start=[0, 0, 400, 1, 0, 0, 0])


@pytest.mark.parametrize(("rows", "count"), [(3, 2), (1, 5)])
def test_a_track_refuses_samples_that_its_rows_exceed(rows, count) -> None:
    """A path is divided further, never thinned."""
    path = np.linspace(0.0, 10.0, rows)[:, None] * np.ones(6)
    with pytest.raises(InputError, match=f"samples = {count} is given.*{rows} sample"):
        symkin.track(symkin.load("gluon_6l3"), joints=path, samples=count)


def test_a_calibration_refuses_forms_that_nothing_reads() -> None:
    """Neighbour differences without groups, joint noise that is not known, a level of no test."""
    rods = symkin.load("ren2008")
    measured = Measurements(np.full((3, 6), 0.1), position=np.zeros((3, 3)))
    for options, words in (
        ({"residual": "differences"}, "residual = 'differences' is given.*no groups"),
        (
            {"residual": "maximum likelihood"},
            "residual = 'maximum likelihood' is given.*sigma-joints",
        ),
        ({"outliers": "ignore", "level": 0.1}, "level is given.*tests no reading"),
    ):
        with pytest.raises(InputError, match=words):
            symkin.calibrate(rods, measured, **options)


def test_a_plan_without_groups_refuses_wedges() -> None:
    workspace = Workspace.about(symkin.load("ren2008"))
    with pytest.raises(InputError, match=r"wedges is given.*groups"):
        plan_measurements(
            workspace, 10, Noise(), groups=0, readings=("pose",), wedges=np.zeros((1, 2))
        )


@pytest.mark.parametrize("kind", ["group", "inclination", "orientation", "distance"])
def test_a_fit_refuses_the_noise_of_readings_that_the_file_lacks(capsys, tmp_path, kind) -> None:
    """A file of positions has no other readings whose standard deviation could be given; theirs is
    read.
    """
    joints = [c.name for c in symkin.load("ren2008").actuated]
    rows = "\n".join(",".join([f"{0.1 + 0.01 * k}"] * 6 + ["0", "0", "1.2"]) for k in range(3))
    data = tmp_path / "data.csv"
    data.write_text(
        ",".join([f"{name}[m]" for name in joints] + ["x[m]", "y[m]", "z[m]"]) + "\n" + rows + "\n"
    )
    status, _, err = run(
        capsys,
        "calibrate",
        "fit",
        "ren2008",
        str(data),
        "-o",
        str(tmp_path / "out"),
        f"--sigma-{kind}",
        "0.001",
    )
    assert status == 2
    assert f"--sigma-{kind} is given" in err
    assert f"holds no {kind}s" in err


def test_one_option_is_told_from_several() -> None:
    """Grammar of the sentence; what is None or False is not given, 0 is."""
    refuse_ignored({"a": None, "b": False}, "x")
    with pytest.raises(InputError, match=r"^b is given and would be ignored: x; leave it out$"):
        refuse_ignored({"a": None, "b": 0}, "x")
    with pytest.raises(
        InputError,
        match=r"^a, b and c are given and would be ignored: x; leave them out, or use y$",
    ):
        refuse_ignored({"a": 1, "b": "", "c": (1,)}, "x", "use y")
