"""The section on the learning presets of the page on environments."""

from docs.tables import numbers, table
from prp_gym.envs.base.error_observation import read_parts
from prp_gym.tasks.presets import LEARNING_KEYWORDS, learning_id
from prp_gym.tasks.spec import TASKS

_TEXT = """Every task has a second id, `{preset}` for `{task}`, whose defaults suit learning algorithms with
the default numbers of their libraries: {keywords}. All keywords of the task can be given as well, such as
`action_mode`. Physics, scenarios, reward, score and metrics are those of the task, and results carry its id.
A controller reads the fields of the task and is refused on a preset. So is a task without joint positions,
joint velocities or a desired motion: it has no errors of the joints.

The observation consists of the parts below that the task has. A part is z, a quantity divided by its scale,
either clipped to ±10 or saturating, z/(1 + |z|), which resolves errors near zero. All parts are computed from
the observed fields and the nominal kinematics, so that they contain the errors of the sensors; where the
reference is a pose, the desired joint motion is that of the pose.

"""


def presets_section() -> str:
    """What the ids of learning presets set, and the parts of their observation."""
    task, *_ = TASKS
    keywords = ", ".join(f"`{name}={value!r}`" for name, value in LEARNING_KEYWORDS.items())
    text = _TEXT.format(preset=learning_id(task), task=task, keywords=keywords)
    headers = ("part", "quantity", "unit", "scale", "curve")
    for kind, parts in read_parts().items():
        rows = ((f"`{p.name}`", p.description, ", ".join(p.unit), numbers(p.scale), p.curve) for p in parts)
        text += f"On the {kind}:\n\n{table(headers, rows)}\n"
    return text
