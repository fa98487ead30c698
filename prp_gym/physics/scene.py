"""Parts of the MJCF documents of all robots: integration, light, floor, cameras."""

import copy
import math
from functools import lru_cache

import mujoco

from prp_gym.errors import InvalidValueError
from prp_gym.robot.parameters import Vector3

FLOOR_HEIGHT = -0.15
"""Height of the drawn floor [m], below the workspace of all robots. It has no contacts."""

FIXED_CAMERAS = ("overview", "top")
"""Cameras that are part of every model."""

CAMERAS = (*FIXED_CAMERAS, "task", "contact")
"""All cameras. `task` frames what matters in the task: the arm and its reference path, or the contact and the
arm beside it; `contact` is a close view of the contact, or of the tip in free space."""

SURFACE_GROUP = 2
"""Group of the geom of the elastic surface, an unbounded plane; frames show a patch of it with an edge."""

_OPTIONS = """
<compiler angle="radian" autolimits="false"/>
<option timestep="{timestep!r}" integrator="Euler" cone="elliptic" impratio="{ratio!r}"
        gravity="0 0 {gravity!r}"><flag contact="{contact}" island="disable"/></option>
<statistic center="0.15 -0.1 0.2" extent="1.0"/>
<visual>
  <global fovy="35" offwidth="1920" offheight="1080"/>
  <headlight ambient="0.38 0.38 0.38" diffuse="0.22 0.22 0.22" specular="0.05 0.05 0.05"/>
  <quality shadowsize="2048"/>
  <map znear="0.01" zfar="20" shadowclip="2.0"/>
</visual>"""

_SCENERY = """
<asset>
  <texture name="sky" type="skybox" builtin="gradient" rgb1="0.97 0.97 0.98" rgb2="0.80 0.83 0.87"
           width="32" height="32"/>
  <texture name="floor" type="2d" builtin="checker" rgb1="0.80 0.81 0.82" rgb2="0.74 0.75 0.77"
           width="256" height="256"/>
  <material name="floor" texture="floor" texrepeat="10 10" texuniform="true" reflectance="0"/>
  <material name="base" rgba="0.23 0.25 0.28 1" specular="0.3"/>
  <material name="link" rgba="0.86 0.87 0.88 1" specular="0.6" shininess="0.6"/>
  <material name="slide" rgba="0.58 0.61 0.65 1" specular="0.4"/>
  <material name="third" rgba="0.86 0.87 0.88 1" specular="0.4"/>
  <material name="tip" rgba="0.12 0.13 0.15 1" specular="0.6" shininess="0.6"/>
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


def geom(kind: str, size: str, material: str, position: str, name: str = "", group: int = 1) -> str:
    """A geom that is drawn and has no contacts."""
    label = f'name="{name}" ' if name else ""
    return (
        f'<geom {label}type="{kind}" size="{size}" material="{material}" {position}'
        f' contype="0" conaffinity="0" group="{group}"/>'
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
