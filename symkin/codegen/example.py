"""Write example_main.c of a generated folder: the loop of a controller, one for every kind of
machine.
"""

from __future__ import annotations

from collections.abc import Mapping

from symkin.codegen.text.c import indexed
from symkin.codegen.text.templates import fill, substitute

_PLATFORM = {
    "about": "where the platform is",
    "answer": "@{p}_pose pose",
    "pose": "",
    "known": "values",
    "next": "&next.pose",
    "last": "&state->pose",
    "track": "track",
    "solve": "direct",
    "home": "@{p}_vector_home",
    "begin": """\
    @{p}_real begin[@{P}_JOINTS];
    if (@{p}_inverse(@{ga}&state.pose, begin) != @{P}_OK) {
        (void)fprintf(stderr, "home cannot be taken; the machine must not move\\n");
        return 1;
    }""",
    "way": "the joints move from home in a straight line",
    "goal": "@{p}_vector_joints",
    "end": "",
    "told": "position %.6f %.6f %.6f",
    "numbers": ", ".join(f"(double)state.pose.position[{i}]" for i in range(3)),
}
_ARM = _PLATFORM | {
    "about": "joint values of tool poses",
    "answer": "@{p}_real joints[@{P}_JOINTS]",
    "pose": """\
    /* the pose that is wanted: that of joint values here */
    @{p}_pose pose = { { (@{p}_real)NAN }, { (@{p}_real)NAN } };
    (void)@{p}_direct(@{ga}values, &pose);""",
    "known": "&pose",
    "next": "next.joints",
    "last": "state->joints",
    "solve": "inverse",
    "home": "@{p}_vector_guesses[0]",
    "begin": "    const @{p}_real *const begin = home;",
    "way": "the tool moves to another pose",
    "told": "first joint %.6f",
    "numbers": "(double)state.joints[0]",
}
_MAP = _ARM | {
    "about": "joints of found values that are wanted, and what they must hold",
    "pose": "",
    "known": "values",
    "track": "track_inverse",
    "home": "@{p}_vector_home_joints",
    "begin": "    const @{p}_real *const begin = @{p}_vector_home_found;",
    "way": "the found values move from home in a straight line",
    "goal": "@{p}_vector_found",
    "end": """\
    /* where they have come to, and what the joints hold of one unit at each found coordinate */
    @{p}_real found[@{P}_FOUND];
    @{p}_real load[@{P}_FOUND];
    @{p}_real torques[@{P}_JOINTS];
    for (int i = 0; i < @{P}_JOINTS; ++i) {
        load[i] = (@{p}_real)1;
    }
    if ((@{p}_direct(NULL, state.joints, begin, found, NULL) != @{P}_OK)
        || (@{p}_torques(state.joints, found, load, torques) != @{P}_OK)) {
        (void)fprintf(stderr, "no answer; the machine must not move\\n");
        return 1;
    }""",
    "told": "joint %.6f found %.6f torque %.6f",
    "numbers": "(double)state.joints[0], (double)found[0], (double)torques[0]",
}
_LOOPS = {"parallel": _PLATFORM, "serial": _ARM, "map": _MAP}


def example_text(machine: str, values: Mapping[str, object]) -> str:
    """Write the example of a kind of machine."""
    loop = {name: substitute(text, values) for name, text in _LOOPS[machine].items()}
    parts = [indexed("home", 3), indexed("home", 4, 3)]
    if machine != "parallel":
        parts = [indexed("home", int(str(values["nq"])))]
    first = ", ".join(f"{{ {', '.join(part)} }}" for part in parts)
    first = f"{{ {first} }}" if len(parts) > 1 else first
    return fill("example.c", {**values, **loop, "first": first})
