"""The part of ``stark.Scene`` that adds bodies. Everything is checked before it is added."""

from __future__ import annotations

import functools
import inspect
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from stark import materials
from stark import mesh as meshes
from stark._core import InvalidArgument, InvalidMesh
from stark.arguments import as_array, given_flag, given_name, given_word, nearest, shown_value
from stark.bodies.body import Body
from stark.bodies.cloth import Cloth
from stark.bodies.rigid import RigidBody
from stark.bodies.rod import Rod
from stark.bodies.solid import Solid
from stark.handle import SceneLink
from stark.materials import RodMaterial, ShellMaterial, SolidMaterial
from stark.rotations import Vec3Like, as_matrix
from stark.surfaces import Surface

_ZERO = (0.0, 0.0, 0.0)
_FLOOR_SIZE = 4.0  # [m]

#: What other simulators call arguments of rigid bodies, and where they are here.
_OTHER_WORDS = {
    "restitution": "; it is of pairs: scene.restitution[body, other] = 0.5",
    "material": "; give mass= or density=, and friction= or surface=",
    "pose": "; give position= and rotation=",
    **dict.fromkeys(("static", "fixed"), "; give motion='fixed'"),
    "kinematic": "; give motion='scripted'",
    **{
        word: f"; assign it to the body: body.{word} = ..."
        for word in ("surface_velocity", "surface_spin", "surface_center", "surface_direction")
    },
    "center_of_mass": "; give inertia=(mass, centre of mass, tensor about it)",
}


class SceneBodies(SceneLink):
    """What ``stark.Scene`` knows about adding bodies."""

    _bodies: list[Body]
    _ghosts: list[Body]  # touch nothing, whatever is added
    _sizeless_floors: list[Body]  # whose size nobody has chosen

    # --- deformable bodies ---

    def add_cloth(
        self,
        mesh: Any,
        material: ShellMaterial = materials.cotton,
        *,
        mass: float | None = None,
        name: str | None = None,
        position: Vec3Like = _ZERO,
        rotation: ArrayLike | None = None,
        velocity: Vec3Like = _ZERO,
        angular_velocity: Vec3Like = _ZERO,
        initial_positions: ArrayLike | None = None,
        rest_angles: str = "flat",
        pins: ArrayLike | None = None,
        self_contact: bool = True,
        contact_distance: float | None = None,
        contact_stiffness: float | None = None,
        surface: Surface | None = None,
        friction: float | None = None,
        color: Vec3Like | None = None,
    ) -> Cloth:
        """Adds a sheet. ``mesh`` is its rest shape; ``position`` [m] and ``rotation`` (matrix or quaternion)
        place it.

        ``mass`` [kg] of the whole replaces the density of the material. ``velocity`` [m/s] and
        ``angular_velocity`` [rad/s], about the origin of the mesh, hold at time 0. ``initial_positions``
        (n, 3) [m], in the frame of the mesh, start it in another shape than that of rest. ``rest_angles`` is
        "flat" or "mesh" (the folds of the mesh are at rest). ``pins``: indices or mask of prescribed
        vertices.
        ``contact_distance`` [m] and ``contact_stiffness`` [Pa]: within the sum of their contact distances
        bodies press on each other, at half of it with the contact stiffness; ``contact.distance`` and
        ``contact.stiffness`` of the settings if left out. ``surface`` gives both (``stark.surfaces``)."""
        _require(material, ShellMaterial, "cloth", "stark.materials.cotton")
        shape = meshes.as_triangle_mesh(mesh, _title("cloth", name))
        if mass is not None:
            material = material._with_mass(mass, _size(shape, "area"), _title("cloth", name))
        given = self._description(
            name,
            shape.vertices,
            position,
            rotation,
            velocity,
            angular_velocity,
            contact_distance,
            contact_stiffness,
            surface,
            friction,
            color,
        )
        given |= {
            "triangles": shape.triangles,
            "initial_positions": initial_positions,
            "self_contact": given_flag(self_contact, f"{_title('cloth', name)}: self_contact"),
            "rest_angles": given_word(rest_angles, f"{_title('cloth', name)}: rest_angles"),
            **material._description(),
        }
        _check_pins(pins, len(shape.vertices), _title("cloth", name))
        cloth = Cloth(self, self._core.add_cloth(given, material._core), shape, color)
        cloth._shared |= {"material": material, "rest_angles": given["rest_angles"]}
        if initial_positions is not None:
            cloth._rest_placement = given["position"], given["rotation"]
        self._append(cloth)
        if pins is not None:
            cloth.pin(pins)
        return cloth

    def add_solid(
        self,
        mesh: Any,
        material: SolidMaterial = materials.soft_rubber,
        *,
        mass: float | None = None,
        name: str | None = None,
        position: Vec3Like = _ZERO,
        rotation: ArrayLike | None = None,
        velocity: Vec3Like = _ZERO,
        angular_velocity: Vec3Like = _ZERO,
        initial_positions: ArrayLike | None = None,
        pins: ArrayLike | None = None,
        formulation: str = "displacement",
        self_contact: bool = True,
        contact_distance: float | None = None,
        contact_stiffness: float | None = None,
        surface: Surface | None = None,
        friction: float | None = None,
        color: Vec3Like | None = None,
    ) -> Solid:
        """Adds a soft volume of tetrahedra (TetMesh) or of quadratic or hexahedral elements (SolidMesh, see
        ``stark.mesh.to_quadratic`` and ``box_hexahedra``); arguments as in ``add_cloth``. Surfaces become
        volumes with ``stark.mesh.tetrahedralise``, or in a coarse lattice with ``stark.mesh.lattice``.

        ``formulation``: "displacement", or "mean_dilatation" for nearly incompressible solids, Poisson's
        ratios from 0.45 on: the law sees the change of volume of the element instead of that at each of its
        points, so that elements do not lock (docs/solids.md); not for linear tetrahedra."""
        _require(material, SolidMaterial, "solid", "stark.materials.soft_rubber")
        volume = meshes.as_solid_mesh(mesh, _title("solid", name))
        if mass is not None:
            material = material._with_mass(mass, _size(volume, "volume"), _title("solid", name))
        given = self._description(
            name,
            volume.vertices,
            position,
            rotation,
            velocity,
            angular_velocity,
            contact_distance,
            contact_stiffness,
            surface,
            friction,
            color,
        )
        given |= {
            "elements": volume.tets if isinstance(volume, meshes.TetMesh) else volume.elements,
            **({"embedding": volume._embedding()} if isinstance(volume, meshes.EmbeddedMesh) else {}),
            "initial_positions": initial_positions,
            "formulation": given_word(formulation, f"{_title('solid', name)}: formulation"),
            "self_contact": given_flag(self_contact, f"{_title('solid', name)}: self_contact"),
            **material._description(),
        }
        _check_pins(pins, len(volume.vertices), _title("solid", name))
        solid = Solid(self, self._core.add_solid(given, material._core), volume, color)
        solid._shared["material"] = material
        solid._warn_of_locking(formulation)
        solid._warn_of_doubles()
        if initial_positions is not None:
            solid._rest_placement = given["position"], given["rotation"]
        self._append(solid)
        if pins is not None:
            solid.pin(pins)
        return solid

    def add_rod(
        self,
        points: Any,
        material: RodMaterial = materials.steel_wire,
        *,
        mass: float | None = None,
        name: str | None = None,
        position: Vec3Like = _ZERO,
        rotation: ArrayLike | None = None,
        velocity: Vec3Like = _ZERO,
        angular_velocity: Vec3Like = _ZERO,
        initial_positions: ArrayLike | None = None,
        rest_shape: str = "mesh",
        normal: Vec3Like | None = None,
        pins: ArrayLike | None = None,
        clamps: ArrayLike | None = None,
        self_contact: bool = True,
        contact_distance: float | None = None,
        contact_stiffness: float | None = None,
        surface: Surface | None = None,
        friction: float | None = None,
        color: Vec3Like | None = None,
    ) -> Rod:
        """Adds a thin elastic rod along ``points`` (n, 3) [m], its nodes: an array or a
        ``stark.mesh.polyline``, ``helix``.

        ``rest_shape`` is "mesh" (the rod is at rest where the points are) or "straight" (without curvature
        and twist, with the same lengths). ``normal`` is the first axis of the section at the first node, in
        the frame of the body; the others follow along the rod without twist. ``pins``: nodes with prescribed
        positions; ``clamps``: nodes with prescribed positions and frames. ``contact_distance`` [m] is the
        radius of the section, or half its thickness, if left out. Other arguments as in ``add_cloth``."""
        _require(material, RodMaterial, "rod", "stark.materials.steel_wire")
        chain = meshes.as_polyline(points, _title("rod", name))
        if mass is not None:
            area = material.section["mass"] / material.density
            material = material._with_mass(mass, area * chain.length, _title("rod", name))
        given = self._description(
            name,
            chain.vertices,
            position,
            rotation,
            velocity,
            angular_velocity,
            contact_distance,
            contact_stiffness,
            surface,
            friction,
            color,
        )
        given |= {
            "initial_positions": initial_positions,
            "normal": normal,
            "rest_shape": given_word(rest_shape, f"{_title('rod', name)}: rest_shape"),
            "self_contact": given_flag(self_contact, f"{_title('rod', name)}: self_contact"),
            **material._description(),
        }
        _check_pins(pins, len(chain.vertices), _title("rod", name))
        _check_pins(clamps, len(chain.vertices), _title("rod", name))
        rod = Rod(self, self._core.add_rod(given, material._core), chain, color)
        rod._shared["material"] = material
        if initial_positions is not None:
            rod._rest_placement = given["position"], given["rotation"]
        self._append(rod)
        if pins is not None:
            rod.pin(pins)
        if clamps is not None:
            rod.clamp(clamps)
        return rod

    # --- rigid bodies ---

    def add_rigid(
        self,
        mesh: Any,
        *,
        mass: float | None = None,
        density: float | None = None,
        inertia: tuple[float, Vec3Like, ArrayLike] | None = None,
        hollow: bool = False,
        motion: str = "dynamic",
        name: str | None = None,
        position: Vec3Like = _ZERO,
        rotation: ArrayLike | None = None,
        velocity: Vec3Like = _ZERO,
        angular_velocity: Vec3Like = _ZERO,
        linear_damping: float = 0.0,
        angular_damping: float = 0.0,
        contact_distance: float | None = None,
        contact_stiffness: float | None = None,
        surface: Surface | None = None,
        friction: float | None = None,
        color: Vec3Like | None = None,
        shown: Any = None,
    ) -> RigidBody:
        """Adds a rigid body with the surface ``mesh``.

        A dynamic body needs one of ``mass`` [kg] (spread over the enclosed volume, or over the surface of
        open meshes), ``density`` [kg/m^3] (closed meshes), ``inertia`` (mass [kg], centre of mass (3,) [m],
        tensor about it (3, 3) [kg m^2], in the frame of the mesh). A closed mesh is the surface of a solid:
        no other body can start inside. With ``hollow=True`` it is a shell with room inside, and ``mass`` is
        spread over the surface; walls of a thickness are a mesh with an outer and an inner surface, which is
        not hollow. ``motion="fixed"`` never moves;
        ``motion="scripted"`` follows the poses that are assigned to it, or its constant ``velocity`` [m/s]
        and ``angular_velocity`` [rad/s] until one is. ``linear_damping`` and ``angular_damping`` in 1/s.
        ``shown`` is a mesh that pictures, replays and exports show instead; it touches nothing and weighs
        nothing."""
        shape = meshes.as_triangle_mesh(mesh, _title("rigid body", name))
        given = self._description(
            name,
            shape.vertices,
            position,
            rotation,
            velocity,
            angular_velocity,
            contact_distance,
            contact_stiffness,
            surface,
            friction,
            color,
        )
        if inertia is not None and (not isinstance(inertia, tuple) or len(inertia) != 3):
            raise InvalidArgument(
                f"{_title('rigid body', name)}: inertia = {inertia!r}: "
                f"must be (mass, centre of mass, 3x3 tensor)"
            )
        given |= {
            "triangles": shape.triangles,
            "motion": str(motion),
            "mass": mass,
            "density": density,
            "inertia": inertia,
            "hollow": given_flag(hollow, f"{_title('rigid body', name)}: hollow"),
            "linear_damping": linear_damping,
            "angular_damping": angular_damping,
        }
        title = f"{_title('rigid body', name)}: shown"
        look = None if shown is None else meshes.as_triangle_mesh(shown, title)
        body = RigidBody(self, self._core.add_rigid(given), shape, color)
        if look is not None:
            body._shared["shown"] = look
        self._append(body)
        return body

    def add_box(self, size: float | ArrayLike, *, subdivisions: int = 1, **options: Any) -> RigidBody:
        """Rigid box about its origin; ``size`` is one edge length or three [m], options as in
        ``add_rigid``."""
        return self._add_shape("box", meshes.box(size, subdivisions), options)

    def add_sphere(self, radius: float, *, subdivisions: int = 3, **options: Any) -> RigidBody:
        """Rigid icosphere; options as in ``add_rigid``."""
        return self._add_shape("sphere", meshes.sphere(radius, subdivisions), options)

    def add_cylinder(self, radius: float, height: float, *, segments: int = 32, **options: Any) -> RigidBody:
        """Rigid cylinder about z; options as in ``add_rigid``."""
        return self._add_shape("cylinder", meshes.cylinder(radius, height, segments), options)

    def add_capsule(self, radius: float, height: float, *, segments: int = 32, **options: Any) -> RigidBody:
        """Rigid capsule about z, ``height`` between the centres of its half spheres; options as in
        ``add_rigid``."""
        return self._add_shape("capsule", meshes.capsule(radius, height, segments), options)

    def add_floor(self, size: float | None = None, *, height: float = 0.0, **options: Any) -> RigidBody:
        """Fixed square of two triangles in the plane z = ``height`` [m], ``size`` [m] (4 m) along x and y,
        seen from above; ``options`` as in ``add_rigid``, for instance friction=0.3. What lies on it must not
        stick out of it: bodies fall off its edge, and if ``size`` is not given and the floor is level and
        fixed, a StarkWarning says so.
        Raises InvalidArgument for numbers out of range, and for what makes no difference to a floor, such as
        a mass."""
        title = _title("floor", options.get("name"))
        if options.get("motion", "fixed") == "fixed":
            _refuse_idle(title, options)
        if options.get("position") is None:
            options.pop("position", None)
        elif not _is_zero(height):
            raise InvalidArgument(
                f"{title}: height = {height!r} m and position = {options['position']!r} are both given: give "
                f"one of them"
            )
        options = {"motion": "fixed", "position": (0.0, 0.0, height), **options}
        side = _FLOOR_SIZE if size is None else size
        floor = self._add_shape("floor", meshes.grid(side, side, 1), options)
        if size is None:
            self._sizeless_floors.append(floor)
        return floor

    # --- details ---

    def _description(
        self,
        name: str | None,
        vertices: meshes.Points,
        position: ArrayLike,
        rotation: ArrayLike | None,
        velocity: ArrayLike,
        angular_velocity: ArrayLike,
        contact_distance: float | None,
        contact_stiffness: float | None,
        surface: Surface | None,
        friction: float | None,
        color: ArrayLike | None,
    ) -> dict[str, Any]:
        if surface is not None:
            if not isinstance(surface, Surface):
                raise InvalidArgument(
                    f"{'body' if name is None else repr(name)}: surface = {surface!r}: must be a "
                    f"stark.Surface, for instance stark.surfaces.rubber"
                )
            contact_distance = surface.thickness if contact_distance is None else contact_distance
            contact_stiffness = surface.stiffness if contact_stiffness is None else contact_stiffness
        return {
            "name": given_name(name),
            "contact_core": 0.0 if surface is None else surface.core,
            "vertices": vertices,
            "position": position,
            "rotation": as_matrix(rotation, f"{'body' if name is None else repr(name)}: rotation"),
            "velocity": velocity,
            "angular_velocity": angular_velocity,
            "contact_distance": contact_distance,
            "contact_stiffness": contact_stiffness,
            "friction": friction,
            "color": color,
        }

    def _add_shape(self, kind: str, mesh: meshes.TriangleMesh, options: dict[str, Any]) -> RigidBody:
        if options.get("name") is None:
            options["name"] = self._core.free_name(kind)
        known = _parameters(type(self).add_rigid)
        for name in sorted(options.keys() - set(known)):
            if not (hint := _OTHER_WORDS.get(name, "")) and (near := nearest(name, known)):
                hint = f"; did you mean '{near}'?"
            raise TypeError(f"add_{kind}() got an unexpected keyword argument '{name}'{hint}")
        return self.add_rigid(mesh, **options)

    def _append(self, body: Body) -> None:
        self._bodies.append(body)
        if self._ghosts:
            self._core.disable_contacts([body._index], [ghost._index for ghost in self._ghosts])
        self._warn()

    def _touches_nothing(self, body: Body) -> None:
        """Neither the bodies that there are nor those that are added later."""
        self._ghosts.append(body)
        if others := [other._index for other in self._bodies if other is not body]:
            self._core.disable_contacts([body._index], others)


@functools.cache
def _parameters(method: Any) -> tuple[str, ...]:
    """Names of what a method takes; finding them costs as much as adding a box."""
    return tuple(inspect.signature(method).parameters)[1:]


def _title(kind: str, name: str | None) -> str:
    return kind if name is None else f"{kind} '{name}'"


def _size(mesh: Any, measure: str) -> float:
    """Area or volume of a mesh, 0 for one whose indices are wrong: the core refuses it, and says which."""
    try:
        return float(getattr(mesh, measure))
    except InvalidMesh:
        return 0.0


def _require(material: Any, kind: type[Any], body: str, example: str) -> None:
    if not isinstance(material, kind):
        raise InvalidArgument(
            f"material of a {body} = {shown_value(material)}: must be a stark.{kind.__name__}, for instance "
            f"{example}"
        )


def _refuse_idle(title: str, options: dict[str, Any]) -> None:
    """What only moving bodies have, of a floor."""
    units = {"mass": "kg", "density": "kg/m^3", "inertia": "", "linear_damping": "1/s"}
    for name, unit in {**units, "angular_damping": "1/s"}.items():
        is_none = options.get(name) is None or (name.endswith("damping") and _is_zero(options[name]))
        if not is_none:
            raise InvalidArgument(
                f"{title}: {name} = {shown_value(options[name])} {unit}".rstrip()
                + ": must be left out, as a floor never moves; give motion='dynamic' to a plate that does"
            )


def _is_zero(value: Any) -> bool:
    return isinstance(value, (int, float, np.number)) and value == 0.0


def _check_pins(pins: ArrayLike | None, vertex_count: int, owner: str) -> None:
    """Before the body exists, so that a refused pin leaves the scene as it was."""
    if pins is None:
        return
    array = as_array(pins, f"{owner}: pins")
    if array.dtype == bool and array.shape == (vertex_count,):
        return
    if array.ndim > 1:
        raise InvalidArgument(f"{owner}: pins of shape {array.shape}: must be a row of vertex indices")
    if (array.size or array.dtype == bool) and array.dtype.kind not in "iu":
        raise InvalidArgument(
            f"{owner}: pins = {shown_value(pins)}: must be indices of vertices, "
            f"like [0, {vertex_count - 1}], "
            f"or a mask of ({vertex_count},)"
        )
    wrong = array[(array < 0) | (array >= vertex_count)] if array.size else array
    if wrong.size:
        raise InvalidArgument(
            f"{owner}: pinned vertex {wrong.flat[0]}: must be in [0, {vertex_count}); give indices of "
            f"vertices of the mesh"
        )
