// Scene: the mutable description of what is simulated, as plain data. Bodies, their layers, materials, pins,
// friction, pairs without contact, joints, actuators, energies of the user's own. Everything is validated
// when it is added, so a scene that exists is a scene that can be built; no numerics happen here.
// sim/model turns it into stencils and parameter tables. SI units.
#pragma once

#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include <stark/base/error.h>
#include <stark/base/math.h>
#include <stark/contact/friction_coefficient.h>
#include <stark/contact/surface_motion.h>
#include <stark/geometry/mesh.h>
#include <stark/geometry/solid_mesh.h>
#include <stark/mechanics/constitutive_law.h>
#include <stark/mechanics/field_values.h>
#include <stark/mechanics/rod_law.h>
#include <stark/sim/scene/actuator.h>
#include <stark/sim/scene/attachment.h>
#include <stark/sim/scene/body_kind.h>
#include <stark/sim/scene/energy.h>
#include <stark/sim/scene/ids.h>
#include <stark/sim/scene/joint.h>
#include <stark/sim/scene/layer.h>
#include <stark/sim/scene/materials.h>
#include <stark/sim/scene/names.h>
#include <stark/sim/scene/rest_shape.h>
#include <stark/sim/scene/settings.h>

namespace stark {

/// Dynamic bodies move by forces. Fixed ones never move. Scripted ones follow poses that the user sets, or
/// else their constant initial velocities; forces do not move them.
enum class Motion : uint8_t { Dynamic, Fixed, Scripted };

/// How the elements of a solid see the ratio of volumes: each point its own, or that of the element, which
/// keeps nearly incompressible solids from locking [theory eq. 15b].
enum class Formulation : uint8_t { Displacement, MeanDilatation };

template <>
struct EnumNames<Formulation> {
  static constexpr std::array<std::string_view, 2> kNames{"displacement", "mean_dilatation"};
};
template <>
struct EnumNames<Motion> {
  static constexpr std::array<std::string_view, 3> kNames{"dynamic", "fixed", "scripted"};
};

struct ClothDescription {
  std::string name{};   ///< unique; empty: "cloth", "cloth_2", ...
  TriangleMesh mesh{};  ///< [m] rest shape, in the frame of the body
  ShellMaterial material{};
  std::optional<ShellLaw> law{};  ///< of the membrane; unset: Neo-Hookean
  /// Parameters of the law that the material does not have, and values that replace those of the material;
  /// also `density`.
  ParameterValues fields{};
  ParameterValues rest_state{};               ///< see Scene::set_rest_state
  Vec3 position{};                            ///< [m] of the frame of the body at time 0
  Mat3 rotation = Mat3::identity();           ///< of the frame of the body at time 0
  std::vector<Vec3> initial_positions{};      ///< [m] in the frame of the body; empty: the rest shape
  Vec3 velocity{};                            ///< [m/s] at time 0
  Vec3 angular_velocity{};                    ///< [rad/s] at time 0, world axes, about `position`
  std::optional<double> contact_distance{};   ///< [m]; unset: settings.contact.distance
  std::optional<double> contact_stiffness{};  ///< [Pa]; unset: settings.contact.stiffness
  double contact_core = 0.0;                  ///< part of contact_distance that no pressure takes [m]
  std::optional<double> friction{};           ///< unset: Scene::default_friction
  bool self_contact = true;
  RestAngles rest_angles = RestAngles::Flat;
  std::optional<Color> color{};
};

struct SolidDescription {
  std::string name{};
  SolidMesh mesh{};  ///< [m] rest shape, of any element type; a TetMesh converts
  SolidMaterial material{};
  std::optional<SolidLaw> law{};  ///< unset: stable Neo-Hookean
  Formulation formulation = Formulation::Displacement;
  ParameterValues fields{};      ///< as of cloth
  ParameterValues rest_state{};  ///< see Scene::set_rest_state
  Vec3 position{};
  Mat3 rotation = Mat3::identity();
  std::vector<Vec3> initial_positions{};
  Vec3 velocity{};
  Vec3 angular_velocity{};
  std::optional<double> contact_distance{};
  std::optional<double> contact_stiffness{};
  double contact_core = 0.0;
  std::optional<double> friction{};
  bool self_contact = true;
  std::optional<Color> color{};
};

/// A chain of points from end to end; edge i joins the points i and i + 1.
struct Polyline {
  std::vector<Vec3> vertices;
};

struct RodDescription {
  std::string name{};
  Polyline mesh{};  ///< [m] nodes, in the frame of the body
  RodMaterial material{};
  std::optional<RodLaw> law{};   ///< unset: linear_rod
  ParameterValues fields{};      ///< of the law; values for each segment where they are per element
  ParameterValues rest_state{};  ///< see Scene::set_rest_state
  RestShape rest_shape = RestShape::Mesh;
  /// First axis d1 of the section at the first node, in the frame of the body, up to its part along the rod;
  /// the frames of the other nodes follow without twist. Unset: the coordinate axis farthest from the rod.
  std::optional<Vec3> normal{};
  Vec3 position{};
  Mat3 rotation = Mat3::identity();
  std::vector<Vec3> initial_positions{};  ///< frames follow those positions, with the same normal
  Vec3 velocity{};
  Vec3 angular_velocity{};
  std::optional<double> contact_distance{};  ///< [m]; unset: the radius, or half the thickness
  std::optional<double> contact_stiffness{};
  double contact_core = 0.0;
  std::optional<double> friction{};
  bool self_contact = true;
  std::optional<Color> color{};

  double default_contact_distance() const {
    return material.width > 0.0 ? 0.5 * std::min(material.width, material.height) : material.radius;
  }
};

/// Mass, centre and inertia of a rigid body in the frame of its mesh.
struct RigidInertia {
  double mass = 0.0;      ///< [kg]
  Vec3 center_of_mass{};  ///< [m]
  Mat3 tensor{};          ///< [kg m^2] about the centre of mass, axes of the mesh frame
};

/// A dynamic body needs a mass or a density (closed meshes), or all of `inertia`; fixed and scripted ones
/// need none.
struct RigidDescription {
  std::string name{};
  TriangleMesh mesh{};  ///< [m] surface for contact and pictures, in the frame of the body
  Motion motion = Motion::Dynamic;
  std::optional<double> mass{};     ///< [kg] spread evenly over the enclosed volume (surface of open meshes)
  std::optional<double> density{};  ///< [kg/m^3]
  std::optional<RigidInertia> inertia{};  ///< overrides what follows from the mesh
  /// A closed surface is that of a solid, unless it is hollow: a shell with room inside, as of a ball or a
  /// can, whose mass is spread over the surface.
  bool hollow = false;
  Vec3 position{};  ///< [m] of the origin of the mesh frame, not of the centre of mass
  Mat3 rotation = Mat3::identity();
  Vec3 velocity{};               ///< [m/s] of the centre of mass (of the origin of a scripted body)
  Vec3 angular_velocity{};       ///< [rad/s] world axes
  double linear_damping = 0.0;   ///< [1/s]
  double angular_damping = 0.0;  ///< [1/s]
  std::optional<double> contact_distance{};
  std::optional<double> contact_stiffness{};
  double contact_core = 0.0;
  std::optional<double> friction{};
  std::optional<Color> color{};
};

/// Vertices of a cloth, solid or rod whose positions are prescribed: they keep their initial position, or
/// follow the targets that Simulation::set_pin_targets gives in this order. They have no unknowns. Nodes of
/// rods may be clamped as well: their frames are prescribed too.
struct Pins {
  std::vector<int32_t> vertices{};  ///< in the order of pinning, no vertex twice
  std::vector<int32_t> clamped{};   ///< nodes among them, in the order of clamping
};

class Scene {
 public:
  /// Numbers of two bodies, ascending.
  using Pair = std::pair<int32_t, int32_t>;

  /// Each validates, takes a copy and returns the id. Throws InvalidArgument or InvalidMesh and leaves the
  /// scene as is.
  BodyId add_cloth(ClothDescription description);
  BodyId add_solid(SolidDescription description);
  BodyId add_rigid(RigidDescription description);
  BodyId add_rod(RodDescription description);

  /// Adds a layer on vertices of a cloth or a solid (sim/scene/layer.h). Throws InvalidArgument or
  /// InvalidMesh for other bodies, vertices that do not exist, degenerate or repeated elements, forbidden
  /// values.
  SkinId add_skin(SkinDescription description);
  FibresId add_fibres(FibresDescription description);
  const std::vector<SkinDescription>& skins() const { return skins_; }
  const std::vector<FibresDescription>& fibres() const { return fibres_; }
  const SkinDescription& skin(SkinId skin) const;
  const FibresDescription& fibres(FibresId fibres) const;

  /// Prescribes vertices of a cloth, a solid or a rod; vertices that are pinned already stay pinned.
  void pin(BodyId body, std::span<const int32_t> vertices);
  /// Prescribes positions and frames of nodes of a rod.
  void clamp(BodyId body, std::span<const int32_t> nodes);

  /// Gives a cloth, a solid or a rod a rest state that simulations may change: fields of
  /// mechanics/rest_state.h with values for each element, which replace those of the same names. Throws
  /// InvalidArgument for fields that the body cannot have and forbidden values.
  void set_rest_state(BodyId body, const ParameterValues& values);
  const ParameterValues& rest_state(BodyId body) const;
  /// Throws InvalidArgument for new values of a rest state that the body must not have.
  void check_rest_state(BodyId body, const ParameterValues& values) const;

  /// Adds an energy of n points (mechanics/potential.h) between points of bodies and of the world. Throws
  /// InvalidArgument for points that do not exist, missing, unknown or non-finite values.
  EnergyId add_energy(EnergyDescription description);
  const std::vector<EnergyDescription>& energies() const { return energies_; }
  const EnergyDescription& energy(EnergyId energy) const;

  /// Adds a joint (mechanics/joint.h) between two frames. Throws InvalidArgument for frames that do not
  /// exist, missing, unknown or non-finite values.
  JointId add_joint(JointDescription description);
  const std::vector<JointDescription>& joints() const { return joints_; }
  const JointDescription& joint(JointId joint) const;

  /// Adds an actuator (mechanics/actuator.h) on a coordinate of a joint. Throws InvalidArgument for
  /// coordinates that do not exist, missing, unknown or forbidden values.
  ActuatorId add_actuator(ActuatorDescription description);
  const std::vector<ActuatorDescription>& actuators() const { return actuators_; }
  const ActuatorDescription& actuator(ActuatorId actuator) const;
  double actuator_value(ActuatorId id, const std::string& name) const { return actuator(id).values.at(name); }
  /// Value that an actuator starts with; throws InvalidArgument for unknown names and forbidden values.
  void set_actuator_value(ActuatorId actuator, const std::string& name, double value);
  void set_actuator_enabled(ActuatorId actuator, bool enabled);

  /// Glues points to points or patches (sim/scene/attachment.h). Throws InvalidArgument for points that do
  /// not exist and counts that differ.
  AttachmentId add_attachment(AttachmentDescription description);
  const std::vector<AttachmentDescription>& attachments() const { return attachments_; }
  const AttachmentDescription& attachment(AttachmentId attachment) const;

  /// Coulomb's coefficients of a pair, for sticking and for sliding contact; the latter is not the larger. a
  /// == b is the self-contact of a body.
  void set_friction(BodyId a, BodyId b, const FrictionCoefficient& coefficient);
  /// Coefficients along and across the surface direction of `a`, or of `b` where `a` has none.
  void set_anisotropic_friction(BodyId a, BodyId b, const AnisotropicFriction& friction);
  /// Coefficient of restitution of two rigid bodies, in [0, 1]: relative speed along the normal after an
  /// impact over that before. Pairs without one bounce as their contact layers, their joints and the
  /// integrator have it. Throws InvalidArgument for deformable bodies, whose materials decide.
  void set_restitution(BodyId a, BodyId b, double coefficient);
  std::optional<double> restitution(BodyId a, BodyId b) const;
  const std::map<Pair, double>& restitutions() const { return restitution_; }
  bool has_restitution() const { return !restitution_.empty(); }
  /// Direction of the surface of a body: one vector, or one for each triangle, in the frame of the body. Its
  /// part in the plane of a triangle counts, not its length nor its sign, and it is carried along with the
  /// deforming triangle. None: no direction. Throws InvalidArgument for rods, zero vectors, other counts.
  void set_surface_directions(BodyId body, std::vector<Vec3> directions);
  std::vector<Vec3> surface_directions(BodyId body) const;
  /// Motion of the material of a rigid body's surface along itself, in the frame of the mesh: a conveyor
  /// belt, a turntable, a track. Simulations begin with its velocity and spin. Throws InvalidArgument for
  /// deformable bodies.
  void set_surface_motion(BodyId body, const SurfaceMotion& motion);
  std::optional<SurfaceMotion> surface_motion(BodyId body) const;  ///< none: the surface rests on its body
  /// Those of all bodies that have one, by body: in the order of State::surface_velocity.
  const std::map<int32_t, SurfaceMotion>& surface_motions() const { return surface_motions_; }
  /// Triangles of the surface in the order of the directions; none of rods.
  std::vector<Index3> surface_triangles(BodyId body) const;
  /// Throws InvalidArgument for anisotropic friction of bodies that both have no direction.
  void check_friction() const;
  bool has_anisotropic_friction() const;
  /// Of a body with others that has no coefficient of the pair: its own, or default_friction().
  double surface_friction(BodyId body) const { return body_friction(body).value_or(default_friction_); }
  /// Pairs that set_friction or set_anisotropic_friction gave coefficients of their own.
  std::vector<std::pair<BodyId, BodyId>> pairs_with_friction() const;
  /// Coefficient of bodies that were given none.
  void set_default_friction(double coefficient);
  double default_friction() const { return default_friction_; }
  /// The pair's own coefficient when set_friction gave one, else the geometric mean of the two bodies'
  /// coefficients, where default_friction() stands in for a body without one. Its frame is the body whose
  /// direction rules, -1 where neither has one.
  FrictionCoefficient friction(BodyId a, BodyId b) const;

  /// Switches contact of a pair off and on, also that of bodies that joints and attachments connect; a == b
  /// is the self-contact of a deformable body.
  void disable_contact(BodyId a, BodyId b);
  void enable_contact(BodyId a, BodyId b);
  /// Of each body of a with each other one of b.
  void disable_contacts(const std::vector<BodyId>& a, const std::vector<BodyId>& b);
  void enable_contacts(const std::vector<BodyId>& a, const std::vector<BodyId>& b);
  const std::set<Pair>& pairs_without_contact() const { return contact_disabled_; }
  /// Those that joints and attachments without contact connect.
  std::set<Pair> pairs_kept_apart() const;
  /// False for pairs that cannot touch, and for those of joints and attachments without contact.
  bool contact_enabled(BodyId a, BodyId b) const;
  /// False for disabled pairs, rigid bodies with themselves and pairs of bodies that are both fixed or
  /// scripted.
  bool contact_possible(BodyId a, BodyId b) const;
  /// Whether it is reported where two prescribed bodies, at least one of them scripted, meet: unless their
  /// contact is off.
  bool meeting_matters(BodyId a, BodyId b) const;
  /// Whether a body fills what its surface encloses, if that is closed: deformable solids and rigid bodies
  /// that are not hollow.
  bool is_filled(BodyId body) const;

  int32_t body_count() const { return static_cast<int32_t>(bodies_.size()); }
  BodyId find(std::string_view name) const;  ///< throws for unknown names, with the nearest one as a hint
  bool contains(const std::string& name) const {
    return body_names_.contains(name) && !layer_names_.contains(name);
  }
  /// `stem`, or the first of stem_2, stem_3, ... that no body has.
  std::string free_name(const std::string& stem) { return body_names_.next(stem); }
  const std::string& name(BodyId body) const { return at(body).name; }
  BodyKind kind(BodyId body) const { return at(body).kind; }
  Motion motion(BodyId body) const;  ///< Dynamic for cloth, solids and rods
  /// Position of the description in cloths(), solids(), rigids() or rods().
  int32_t index_in_kind(BodyId body) const { return at(body).index_in_kind; }
  /// cloth(body), solids(), ...: descriptions of a kind; the former throw for bodies of other kinds.
#define STARK_BODY_KIND(Kind, name)                                          \
  const std::vector<Kind##Description>& name##s() const { return name##s_; } \
  const Kind##Description& name(BodyId body) const { return name##s_[body_of_kind(body, BodyKind::Kind)]; }
#include <stark/sim/scene/body_kinds.inc>
  /// Calls function(description) with the description of a body of any kind.
  template <typename Function>
  decltype(auto) visit(BodyId body, Function&& function) const {
    switch (kind(body)) {
#define STARK_BODY_KIND(Kind, name) \
  case BodyKind::Kind:              \
    return function(name(body));
#include <stark/sim/scene/body_kinds.inc>
    }
    throw InternalError("a body of an unknown kind");
  }
  /// Elements of a solid, null of other bodies.
  const SolidMesh* solid_mesh(BodyId body) const {
    return visit(body, [](const auto& b) -> const SolidMesh* {
      if constexpr (std::is_same_v<decltype(b.mesh), SolidMesh>) return &b.mesh;
      return nullptr;
    });
  }
  /// Rest positions [m] of the vertices, in the frame of the body.
  const std::vector<Vec3>& rest_vertices(BodyId body) const;
  const RigidInertia& rigid_inertia(BodyId body) const;  ///< zero mass for fixed and scripted bodies
  const Pins& pins(BodyId body) const { return pins_[at_index(body)]; }
  std::optional<double> contact_distance(
      BodyId body) const;  ///< unset: settings.contact.distance; rods have one
  std::optional<double> contact_stiffness(BodyId body) const;  ///< unset: settings.contact.stiffness
  double contact_core(BodyId body) const;                      ///< [m]
  std::optional<double> body_friction(BodyId body) const;
  std::optional<Color> color(BodyId body) const;

  /// Positions [m] of the vertices at time 0 in the world, any kind of body.
  std::vector<Vec3> initial_positions(BodyId body) const;
  /// Frames of the nodes of a rod at time 0 in the world, axes d1, d2, d3 as columns.
  std::vector<Mat3> initial_frames(BodyId body) const;
  /// Velocities [m/s] of the vertices at time 0 in the world, cloth, solids and rods.
  std::vector<Vec3> initial_velocities(BodyId body) const;

  /// Findings that do not prevent a simulation: non-manifold edges, unused vertices of rigid meshes, ...
  const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  struct Body {
    std::string name;
    BodyKind kind;
    int32_t index_in_kind;
  };
  size_t at_index(BodyId body) const;                       ///< throws for ids of another scene
  size_t body_of_kind(BodyId body, BodyKind wanted) const;  ///< index in its list; throws for other kinds
  const Body& at(BodyId body) const { return bodies_[at_index(body)]; }
  void check_vertices(BodyId body, std::string_view action, std::span<const int32_t> vertices) const;
  BodyId append(std::string name, BodyKind kind, size_t index_in_kind);
  std::string unique_name(const std::string& name, BodyKind kind);
  /// Owner of messages about a layer, which gets a name where it has none.
  std::string name_layer(const std::string& kind, BodyId body, std::string& name);
  void check_points(const std::string& owner, const PointSet& points) const;
  void check_not_itself(const std::string& owner, const AttachmentDescription& attachment) const;
  void check_patches(const std::string& owner, const AttachmentDescription& attachment) const;
  void check_frame(const std::string& owner, const FrameDescription& frame) const;
  Pair ordered(BodyId a, BodyId b) const;
  bool has_surface_direction(BodyId body) const;

  std::vector<Body> bodies_;
#define STARK_BODY_KIND(Kind, name) std::vector<Kind##Description> name##s_;
#include <stark/sim/scene/body_kinds.inc>
  std::vector<RigidInertia> inertias_;  // parallel to rigids_
  std::vector<Pins> pins_;              // parallel to bodies_
  std::vector<EnergyDescription> energies_;
  std::vector<JointDescription> joints_;
  std::vector<ActuatorDescription> actuators_;
  std::vector<AttachmentDescription> attachments_;
  std::vector<SkinDescription> skins_;
  std::vector<FibresDescription> fibres_;
  Names body_names_, layer_names_;  // names of layers are among those of bodies too
  Names energy_names_, joint_names_, actuator_names_, attachment_names_;
  std::map<Pair, FrictionCoefficient> friction_;  // frame: the body that was named first
  std::map<Pair, double> restitution_;
  std::map<int32_t, std::vector<Vec3>> surface_directions_;
  std::map<int32_t, SurfaceMotion> surface_motions_;
  std::set<Pair> contact_disabled_;
  double default_friction_ = 0.5;
  std::vector<std::string> warnings_;
};

}  // namespace stark
