"""Parts of the MJCF documents of all robots: integration, light, floor, cameras."""

import copy
import math
from functools import lru_cache

import mujoco

from prp_gym.errors import InvalidValueError
from prp_gym.robot.parameters import Vector3

FLOOR_HEIGHT = -0.15
"""Height of the drawn floor [m], below the workspace of all robots. It has no contacts."""

CAMERAS = ("overview", "top")

_OPTIONS = """
<compiler angle="radian" autolimits="false"/>
<option timestep="{timestep!r}" integrator="Euler" cone="elliptic" impratio="{ratio!r}"
        gravity="0 0 {gravity!r}"><flag contact="{contact}" island="disable"/></option>
<statistic center="0.15 -0.1 0.2" extent="1.0"/>
<visual>
  <headlight ambient="0.30 0.30 0.30" diffuse="0.25 0.25 0.25" specular="0.05 0.05 0.05"/>
  <quality shadowsize="1024"/>
  <map znear="0.01" zfar="20" shadowclip="2.5"/>
</visual>"""

_SCENERY = """
<asset>
  <texture name="sky" type="skybox" builtin="gradient" rgb1="0.80 0.88 0.95" rgb2="0.45 0.55 0.68"
           width="32" height="32"/>
  <texture name="floor" type="2d" builtin="checker" rgb1="0.62 0.64 0.66" rgb2="0.55 0.57 0.60"
           width="256" height="256"/>
  <material name="floor" texture="floor" texrepeat="5 5" texuniform="true" reflectance="0"/>
  <material name="base" rgba="0.25 0.27 0.30 1" specular="0.3"/>
  <material name="link" rgba="0.74 0.77 0.80 1" specular="0.6" shininess="0.6"/>
  <material name="slide" rgba="0.20 0.45 0.70 1" specular="0.4"/>
  <material name="third" rgba="0.90 0.55 0.20 1" specular="0.4"/>
  <material name="tip" rgba="0.75 0.15 0.15 1" specular="0.4"/>
  <material name="surface" rgba="0.35 0.75 0.50 0.30" specular="0"/>
</asset>
<worldbody>
<light name="sun" pos="0.5 -0.6 2.0" dir="-0.2 0.3 -0.9" directional="true"
       diffuse="0.55 0.55 0.55" specular="0.2 0.2 0.2"/>
<geom name="floor" type="plane" pos="0 0 @FLOOR@" size="1.5 1.5 0.05" material="floor"
      contype="0" conaffinity="0"/>
<camera name="overview" pos="1.15 -1.25 0.95" xyaxes="0.78 0.62 0 -0.33 0.41 0.85" fovy="45"/>
<camera name="top" pos="0.1 0 2.0" xyaxes="1 0 0 0 1 0" fovy="45"/>"""


def check_timestep(timestep: float) -> float:
    """The timestep [s] as a plain float.

    Raises:
        InvalidValueError: The timestep is not positive or not finite.
    """
    if not (timestep > 0.0 and math.isfinite(timestep)):
        raise InvalidValueError("timestep", timestep, "above 0 and finite", "s")
    return float(timestep)


def opening(timestep: float, gravity: float, contact: bool = False, impedance_ratio: float = 1.0) -> str:
    """Options and scenery of a document, up to the robot in its world body.

    Args:
        timestep: Time step of the integration, which is semi-implicit Euler [s].
        gravity: Magnitude of the gravitational acceleration, which points along -z [m/s^2].
        contact: Whether contacts are possible; without them MuJoCo skips collision detection.
        impedance_ratio: MuJoCo's `impratio`.

    Returns:
        Text of the document; the caller closes `worldbody`.
    """
    flag = "enable" if contact else "disable"
    options = _OPTIONS.format(timestep=timestep, gravity=0.0 - gravity, ratio=impedance_ratio, contact=flag)
    return options + _SCENERY.replace("@FLOOR@", repr(FLOOR_HEIGHT))


def numbers(*values: float) -> str:
    """Value of an attribute with all digits."""
    return " ".join(repr(float(value)) for value in values)


def inertial(mass: float, center: Vector3, moments: Vector3) -> str:
    """A body's mass [kg], centre of mass [m] and principal moments about it [kg m^2], in the body's frame."""
    return f'<inertial mass="{mass!r}" pos="{numbers(*center)}" diaginertia="{numbers(*moments)}"/>'


def geom(kind: str, size: str, material: str, position: str, name: str = "") -> str:
    """A geom that is drawn and has no contacts."""
    label = f'name="{name}" ' if name else ""
    return (
        f'<geom {label}type="{kind}" size="{size}" material="{material}" {position}'
        ' contype="0" conaffinity="0" group="1"/>'
    )


def motors(joints: tuple[str, ...]) -> str:
    """A motor without gear or limit for each joint, named like the joint."""
    each = (f'<motor name="{joint}" joint="{joint}"/>' for joint in joints)
    return "<actuator>" + "".join(each) + "</actuator>"


def compile_mjcf(document: str) -> mujoco.MjModel:
    """A copy of the compiled model of an MJCF document; equal documents are compiled once."""
    return copy.copy(_compiled(document))


@lru_cache(maxsize=16)
def _compiled(document: str) -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(document)
