"""Stark: strongly coupled simulation of rigid bodies, cloth and soft solids with frictional contact.

    import stark

    scene = stark.Scene()
    cloth = scene.add_cloth(stark.mesh.grid(0.4, 0.4, cells=32), stark.materials.cotton)
    box = scene.add_box(size=0.08, position=(0, 0, -0.08), motion="scripted")
    sim = stark.Simulation(scene, contact_distance=0.0025)
    for step in sim.run(until=10.0):
        box.rotation = stark.rotation(axis="z", angle=90 * stark.deg * step.time)

SI units throughout. Recording, pictures and the command line are in stark.recording, stark.render and
stark.cli."""

from stark._cpu import require_supported_processor
from stark._interrupts import leave_while_starting

leave_while_starting()
require_supported_processor()

from stark import materials, mesh, surfaces  # noqa: E402
from stark._core import (  # noqa: E402
    Diagnosis,
    Error,
    InitialIntersection,
    InternalError,
    InvalidArgument,
    InvalidMesh,
    InvalidSetting,
    State,
    StepProgress,
    StepReport,
    TraceError,
    __version__,
)
from stark.attributes import name_methods as _name_methods  # noqa: E402
from stark.bodies import Body, Cloth, Fibres, Layer, RigidBody, Rod, Skin, Solid  # noqa: E402
from stark.bodies.friction import Anisotropic  # noqa: E402
from stark.bodies.sensors import ClosestPoints, Contacts, FreePath, Imu  # noqa: E402
from stark.errors import StarkWarning  # noqa: E402
from stark.joints.handle import Joint as _Joint  # noqa: E402
from stark.materials import RodMaterial, ShellMaterial, SolidMaterial  # noqa: E402
from stark.mesh import SolidMesh, TetMesh, TriangleMesh  # noqa: E402
from stark.on_demand import attach  # noqa: E402
from stark.rotations import deg, rotation, to_quaternion  # noqa: E402
from stark.scene import Scene  # noqa: E402
from stark.settings import Settings  # noqa: E402
from stark.simulation import Simulation  # noqa: E402
from stark.steps import StepFailed  # noqa: E402
from stark.surfaces import Surface  # noqa: E402

# Tracebacks and pickles name the public place of the exceptions.
for _exception in (
    Error,
    InvalidArgument,
    InvalidSetting,
    InvalidMesh,
    InitialIntersection,
    TraceError,
    InternalError,
    StarkWarning,
):
    _exception.__module__ = "stark"

# Errors of Python on arguments name the class that users know.
for _class in (Scene, Simulation, _Joint):
    _name_methods(_class)

# What a scene does not need is imported when it is first used. __init__.pyi has all names with their types.
_MODULES = (
    "actuators",
    "attachments",
    "calibration",
    "checkpoint",
    "curves",
    "document",
    "exports",
    "formulas",
    "gym",
    "joints",
    "measured",
    "motion",
    "recording",
    "render",
    "replay",
    "reproducer",
    "robots",
    "scenes",
    "study",
    "symbolic",
    "telemetry",
    "verify",
    "view",
)
_PLACES = {
    "stark.formulas": (
        "CauchyGreen DeformationGradient Edge Energy Frame Hinge Mat2 Mat3 Point Stencil "
        "Tetrahedron Time TimeStep Triangle ShellDeformationGradient Vec2 Vec3 Vec4 energy material "
        "generalized_maxwell generalized_maxwell_rod generalized_maxwell_shell internal j2_plasticity "
        "j2_viscoplasticity ogden_roxburgh parameter stencils world_frame world_points"
    ),
    "stark.joined_points": "JoinedPoints joined",
    "stark.joints": "Joint Wrench hold joint",
    "stark.attachments": "Attachment",
    "stark.checkpoint": "Checkpoint CheckpointError",
    "stark.calibration": "Fit fit",
    "stark.reproducer": "ReproducerError",
    "stark.document": "DocumentError load_scene",
    "stark.actuators": "Actuator Coordinate Memory act actuator",
    "stark.symbolic": (
        "Mat Matrix Scalar Vec Vector abs acos asin atan atan2 clip columns cos cosh cross "
        "determinant diag dot exp fma held identity invariants inverse log mat maximum minimum norm "
        "normalized outer pow power_trace sin sinh skew sqrt square squared_norm tan tanh total trace "
        "transpose vec where"
    ),
}

__getattr__, __dir__ = attach("stark", _PLACES, _MODULES)

__all__ = [
    "Anisotropic",
    "Body",
    "ClosestPoints",
    "Cloth",
    "Contacts",
    "Diagnosis",
    "Error",
    "Fibres",
    "FreePath",
    "Imu",
    "InitialIntersection",
    "InternalError",
    "InvalidArgument",
    "InvalidMesh",
    "InvalidSetting",
    "Layer",
    "RigidBody",
    "Rod",
    "RodMaterial",
    "Scene",
    "Settings",
    "ShellMaterial",
    "Simulation",
    "Skin",
    "Solid",
    "SolidMaterial",
    "SolidMesh",
    "StarkWarning",
    "State",
    "StepFailed",
    "StepProgress",
    "StepReport",
    "Surface",
    "TetMesh",
    "TraceError",
    "TriangleMesh",
    "__version__",
    "deg",
    "materials",
    "mesh",
    "rotation",
    "surfaces",
    "to_quaternion",
]
