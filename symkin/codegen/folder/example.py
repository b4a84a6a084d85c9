"""Write example_main.c of a generated folder: the loop of a controller, one for every kind of
machine.
"""

from __future__ import annotations

from collections.abc import Mapping

from symkin.codegen.text.c import indexed
from symkin.codegen.text.templates import fill, substitute

_PLATFORM = {
    "about": "where the platform is",
    "answer": "name_pose pose",
    "pose": "",
    "known": "values",
    "next": "&next.pose",
    "last": "&state->pose",
    "track": "track",
    "solve": "direct",
    "home": "name_vector_home",
    "begin": """\
    name_real begin[NAME_JOINTS];
    if (name_inverse(@{ga}&state.pose, begin) != NAME_OK) {
        (void)fprintf(stderr, "home cannot be taken; the machine must not move\\n");
        return 1;
    }""",
    "way": "the joints move from home in a straight line",
    "goal": "name_vector_joints",
    "end": "",
    "told": "position %.6f %.6f %.6f",
    "numbers": ", ".join(f"(double)state.pose.position[{i}]" for i in range(3)),
}
_ARM = _PLATFORM | {
    "about": "joint values of tool poses",
    "answer": "name_real joints[NAME_JOINTS]",
    "pose": """\
    /* the pose that is wanted: that of joint values here */
    name_pose pose = { { (name_real)NAN }, { (name_real)NAN } };
    (void)name_direct(@{ga}values, &pose);""",
    "known": "&pose",
    "next": "next.joints",
    "last": "state->joints",
    "solve": "inverse",
    "home": "name_vector_guesses[0]",
    "begin": "    const name_real *const begin = home;",
    "way": "the tool moves to another pose",
    "told": "first joint %.6f",
    "numbers": "(double)state.joints[0]",
}
_MAP = _ARM | {
    "about": "joints of found values that are wanted, and what they must hold",
    "pose": "",
    "known": "values",
    "track": "track_inverse",
    "home": "name_vector_home_joints",
    "begin": "    const name_real *const begin = name_vector_home_found;",
    "way": "the found values move from home in a straight line",
    "goal": "name_vector_found",
    "end": """\
    /* where they have come to, and what the joints hold of one unit at each found coordinate */
    name_real found[NAME_FOUND];
    name_real load[NAME_FOUND];
    name_real torques[NAME_JOINTS];
    for (int i = 0; i < NAME_JOINTS; ++i) {
        load[i] = (name_real)1;
    }
    if ((name_direct(NULL, state.joints, begin, found, NULL) != NAME_OK)
        || (name_torques(state.joints, found, load, torques) != NAME_OK)) {
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
