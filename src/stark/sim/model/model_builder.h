// Turns a scene into a model, body by body: one file per kind of body, one method per family of energies.
// Internal to sim.
#pragma once

#include <map>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <vector>

#include <stark/base/hash.h>
#include <stark/mechanics/field_values.h>
#include <stark/sim/model/model.h>
#include <stark/sim/scene/layers.h>
#include <stark/sim/scene/material_fields.h>
#include <stark/sim/scene/registry.h>

namespace stark {

/// Edges of a mesh and the part of a measure (area, volume) of its elements that each stands for.
struct WeightedEdges {
  std::vector<Index2> edges;
  std::vector<double> weights;
};

/// Sites of the segments of fibres and, node by node, of their seams (models/rods/fibre_seam.cpp).
struct FibreStencils {
  std::vector<int32_t> segments, seams;
  std::vector<double> reaches;  ///< of each node: the longer of its edges [m]
};

struct Model::Builder {
  Builder(Model& m, Energies& e, const Scene& s, const Settings& t)
      : model(m), energies(e), scene(s), settings(t) {}

  void build();

  // Points and rigid bodies (model_deformables.cpp, model_rigids.cpp, model_rods.cpp)
  void add_deformables();
  /// Vertices that follow elements (geometry/embedding.h).
  void add_embedded_sites(const SolidMesh& mesh, const ModelBody& body);
  void set_masses(const ModelBody& body, std::span<const double> masses, double damping);
  void add_rigids();
  void add_rigid_sites();
  void add_axis_sites(int32_t body);
  /// Where friction of the corners of flat faces acts.
  void add_levers();
  void add_rods();
  void add_rod_nodes(BodyId id);
  void add_rod_sites();
  void set_initial_rods();

  // Layers of bodies (model_layers.cpp)
  /// Adds the masses of all layers to the points.
  void add_layer_masses();
  void add_point_masses(BodyId body, std::span<const double> masses, double damping);
  void add_fibre_frames();
  void add_fibre_sites();
  void add_fibre_path(const FibresDescription& fibres, const std::vector<int32_t>& path,
                      const PathFrames& frames, int32_t first_frame, FibreStencils& out);
  void add_layer_energies();
  void set_initial_fibres();

  // Energies of each kind of body
#define STARK_BODY_KIND(Kind, name) void add_energies(BodyId id, const Kind##Description& body);
#include <stark/sim/scene/body_kinds.inc>
  void add_shell_energies(const ClothDescription& sheet, const ModelBody& body, const std::string& name);
  void add_quadrature_batch(const SolidMesh& mesh, const ElasticEnergy& elastic,
                            std::span<const int32_t> stencils, const std::string& body);
  // Bending of shells (model_bending.cpp)
  void add_bending(const ClothDescription& sheet, const ModelBody& body, const std::string& name);
  void add_hinges(const ClothDescription& sheet, const ModelBody& body, const std::string& name);
  void add_plate(const ClothDescription& sheet, const ModelBody& body, const std::string& name);
  void add_elements(const SolidMesh& mesh, const ElasticEnergy& energy, const ModelBody& body,
                    const std::string& name);
  /// One batch for each edge of an element, whose values are those of the elements. `elements`: their sites.
  void add_grown_edge_limit(std::span<const Index2> edges, std::span<const int32_t> elements,
                            std::span<const double> volumes, const PotentialDefinition& definition,
                            ParameterValues values, const std::string& name);
  void add_strain_limit(const ClothDescription& sheet, const ModelBody& body, const std::string& name);
  void add_strain_limit(const SolidDescription& solid, const ModelBody& body, const std::string& name);
  void add_edge_limit(const WeightedEdges& edges, double scale, double limit, double stiffness,
                      const ModelBody& body, const std::string& name);
  void add_inertia();

  // The user's own energies (model_energies.cpp)
  /// Whether a site follows nodes, as embedded vertices do.
  bool follows(int32_t site) const { return sites[site].kind == SiteKind::Embedded; }
  /// Row of what a point between vertices, some of them embedded, follows.
  int32_t add_combined_row(const ModelBody& body, const Index4& vertices,
                           const std::array<double, 4>& weights);
  /// Adds a site and its place, or direction, at rest; returns its number.
  int32_t add_site(const Site& site, const Vec3& rest);
  /// Of a point of a rigid body, in the world at rest.
  int32_t add_rigid_site(const ModelBody& body, const Vec3& place);
  /// Of a point between vertices.
  int32_t add_embedded_site(const ModelBody& body, const Index4& vertices,
                            const std::array<double, 4>& weights);
  std::vector<int32_t> add_point_sites(const PointSet& points);
  void add_energy_sites();
  void add_energies();

  // Joints (model_joints.cpp)
  std::vector<int32_t> add_frame_sites(const FrameDescription& frame);
  void add_joint_sites();
  void add_joints();
  ConstraintGroup make_group(std::shared_ptr<const Joint> joint, const std::vector<int32_t>& members) const;
  /// Placements and constants of a joint, in fields whose names start with `prefix`.
  void set_joint_fields(PotentialBatch& batch, int64_t element, const JointDescription& joint,
                        const std::string& prefix) const;
  std::vector<double> placement(const FrameDescription& frame) const;
  JointSide side_of(const FrameDescription& frame) const;
  /// The point of a vertex, or those that it follows.
  std::vector<int32_t> carriers_of(int32_t site) const;
  static FrameKind kind_of(const FrameDescription& frame);
  static FrameKind kind_of_b(const JointDescription& joint);
  /// Numbers that place a frame on a patch with vertices at p (mechanics/joint.h, kPatchNumbers).
  static std::vector<double> patch_numbers(const FrameDescription& frame, const std::array<Vec3, 3>& p);

  // Actuators (model_actuators.cpp)
  /// Appends the groups and the sides of all actuators, numbered on from the joints.
  void add_actuators(std::vector<ConstraintGroup>& groups);
  ConstraintGroup make_actuator_group(const std::shared_ptr<const Actuator>& actuator,
                                      const std::vector<int32_t>& members) const;
  /// Where their numbers are in the state; afterwards, what they are at time 0.
  void locate_actuators();
  void set_initial_actuators();
  int coordinate_index(const CoordinateName& coordinate) const;

  // Attachments (model_attachments.cpp)
  void add_attachment_sites();
  std::vector<int32_t> add_carrier_sites(const PointSet& points);
  /// Appends the groups and the sides of all pairs, numbered on from joints and actuators.
  void add_attachments(std::vector<ConstraintGroup>& groups);
  JointSide side_of_sites(std::span<const int32_t> some) const;
  void set_carried_places(PotentialBatch& batch, std::span<const int32_t> pairs) const;
  /// Constraints that can hold what they find, and the places that they have.
  void list_held_places();
  /// Places points on their patches as they are at x, the positions at time 0.
  void set_initial_attachments(std::span<const Vec3> x);

  // What the model was made of (model_parts.cpp)
  void list_parts();
  void list_bodies();
  void list_energies();
  void list_contact();
  void add_part(const std::string& name, bool is_structure, const Hash64& hash);
  void append_places(Hash64& hash, std::span<const int32_t> stencils) const;
  void list_batch(const std::string& name, const PotentialBatch& batch, std::span<const int32_t> stencils);

  // Everything else (model.cpp)
  symbolic::Backend backend() const { return settings.execution.backend; }
  std::shared_ptr<const Potential> compile(const PotentialDefinition& definition,
                                           const std::set<std::string>& per_element = {}) const;
  /// `owner`: name of the body or energy.
  PotentialBatch& add_batch(const PotentialDefinition& definition, std::span<const int32_t> stencils,
                            const std::string& owner, const ParameterValues& values = {});
  /// The same for an energy of the strain of each triangle or tetrahedron of the owner, in their order.
  PotentialBatch& add_stress_batch(const PotentialDefinition& definition, std::span<const int32_t> stencils,
                                   const std::string& owner, const ParameterValues& values);
  /// Bodies that turn as a whole in a Newton step.
  std::vector<TurningRange> turning_ranges() const;
  /// By body: whether joints or attachments hold it.
  std::vector<bool> held_bodies() const;
  void set_block_scales();
  void set_initial_state();
  void set_initial_sites();
  /// Rates of the coordinates of joints at time 0, with the sites at x.
  void set_initial_rates(std::span<const Vec3> x);
  void compile_contact();

  template <typename Element>
  static std::vector<int32_t> offset_stencils(const std::vector<Element>& elements, int32_t first_site) {
    std::vector<int32_t> stencils;
    for (const Element& element : elements)
      for (const int32_t v : element) stencils.push_back(first_site + v);
    return stencils;
  }

  Model& model;
  Energies& energies;
  const Scene& scene;
  const Settings& settings;
  std::vector<Site> sites;
  EmbeddedPoints embedded;                                 ///< that sites follow
  std::vector<bool> point_prescribed;                      ///< without unknowns
  std::vector<bool> body_prescribed, rotation_prescribed;  ///< by index in the state's body arrays
  std::vector<int32_t>
      rigid_bodies;  ///< body ids in the order of the state's body arrays; rods, then fibres come after
  /// By index in the state's body arrays: the centre of mass or node, the first of the three axes; -1: none.
  std::vector<int32_t> centre_sites, axis_sites;
  std::vector<FibreStencils> fibre_stencils;          ///< by fibres of the scene
  std::vector<std::vector<int32_t>> energy_stencils;  ///< by energy of the scene
  std::vector<std::vector<int32_t>> joint_sites;      ///< by joint: points of frame a, then of frame b
  /// By pair: the point, then the point or the three vertices of the patch that carry it.
  std::vector<std::vector<int32_t>> attachment_sites;
  /// By pair: the four points of the frame that carries it, where it can hold what it finds.
  std::vector<std::vector<int32_t>> attachment_frames;
  std::map<std::string, size_t> part_places;  ///< in model.parts_, by name
};

}  // namespace stark
