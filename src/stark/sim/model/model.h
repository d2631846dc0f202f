// The frozen result of building a scene: dof layout, sites, masses, collision surfaces, and where bodies,
// joints and energies are in the arrays of the state. It never changes; energies, which have inputs that
// change from step to step, are beside it (sim/model/energies.h).
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <stark/contact/pipeline.h>
#include <stark/mechanics/incremental_potential.h>
#include <stark/mechanics/state.h>
#include <stark/sim/model/energies.h>
#include <stark/sim/scene/scene.h>

namespace stark {

/// Where a body of the scene lives in the arrays of the model.
struct ModelBody {
  BodyKind kind = BodyKind::Cloth;
  int32_t first_site = 0, site_count = 0;  ///< vertices of the body's mesh, in its order
  int32_t rigid_index = -1;                ///< into the state's body arrays; of rods: of the first node
  std::vector<Index3> triangles;           ///< surface, indices into the body's vertices
  Vec3 centre;                             ///< rigid: origin of the body frame in the mesh frame [m]
  Mat3 axes = Mat3::identity();            ///< rigid: axes of the body frame in the mesh frame
  std::vector<Index2> edges;               ///< that touch others, of bodies without triangles
  std::vector<int32_t> pins;               ///< prescribed vertices
  std::vector<int32_t> clamped;            ///< rods: nodes with prescribed frames

  /// Of bodies and frames in the arrays of the state.
  int32_t rigid_count() const { return is_rigid(kind) ? 1 : has_nodes(kind) ? site_count : 0; }
};

/// Mass distribution of a rigid body in its principal frame, or of a node of a rod in its frame. Nodes of
/// fibres only turn: their mass is that of a vertex.
struct RigidMass {
  double mass = 0.0;    ///< [kg], 0 for fixed and scripted bodies
  Vec3 moments;         ///< principal moments of inertia [kg m^2]
  Vec3 second_moments;  ///< tr(J)/2 - J_k: integral of rho x_k^2 [kg m^2]
  double reach = 0.0;   ///< largest distance of a vertex from the centre of mass; rods: of the next node [m]
  double resistance =
      0.0;  ///< what torques are measured against: the smallest moment; rods: m reach^2 [kg m^2]
  double linear_damping = 0.0, angular_damping = 0.0;  ///< [1/s]
  bool is_frame = false;                               ///< of a node of a rod or of fibres
};

/// What a frame of a joint moves: how firmly its carrier resists (mechanics/constraint_set.h).
struct JointSide {
  std::vector<int32_t> blocks;  ///< translation of a rigid body, or vertices of a patch; empty: prescribed
  int32_t rotation_block = kNoBlock;  ///< of a rigid body, or of a node of a rod, pinned ones included
  double mass = 0.0, moment = 0.0;    ///< [kg], [kg m^2]
  double reach = 0.0;                 ///< size of a patch [m]
  double lever = 0.0;                 ///< of the frame or point on its rigid body or node [m]
};

/// An actuator and where its numbers are in the arrays of the state.
struct ModelActuator {
  std::shared_ptr<const Actuator> law;
  int64_t value = 0, memory = 0, effort = 0;  ///< first parameter, memory and effort
  std::vector<int64_t> coordinates;           ///< in joint_coordinate and joint_rate
  std::vector<bool> is_angle;                 ///< by coordinate
};

/// Pairs of an attachment of the scene.
struct ModelAttachment {
  int32_t first_pair = 0;        ///< in attachment_held of the state
  int32_t first_constraint = 0;  ///< in the constraint set: its pairs follow joints and actuators
};

/// A constraint that can hold what it finds where it is: its frame b is FrameKind::Placed
/// (sim/model/held_places.h).
struct HeldPlace {
  int32_t constraint = 0;
  int64_t first = 0;      ///< in State::held_place
  bool has_axes = false;  ///< kPlaceNumbers there; else the position alone, of a pair of an attachment
};

/// A point inside a flat face of a rigid body, where friction of a vertex of its border acts
/// (geometry/face_levers.h).
struct ModelLever {
  int32_t site = 0, body = 0;
  int32_t vertex = 0, triangle = 0;  ///< of the body's mesh
};

/// Frames of the nodes of fibres, path by path, in the body arrays of the state; without bending there are
/// none.
struct ModelFibres {
  int32_t first_frame = 0, frame_count = 0;
};

/// A part of what a model was made of and a hash of it: "mesh of cloth 'towel'". Models with the same parts
/// and settings go on from a state with the same bits.
struct ModelPart {
  std::string name;
  bool is_structure = false;  ///< a state does not fit a model in which it differs
  uint64_t hash = 0;
};

class Model {
 public:
  /// Writes the energies of the scene, with rest shapes and parameters, to `out_energies`.
  Model(const Scene& scene, const Settings& settings, Energies& out_energies);

  const KinematicMap& map() const { return map_; }
  const std::vector<ModelBody>& bodies() const { return bodies_; }
  const std::vector<RigidMass>& rigid_masses() const { return rigid_masses_; }
  const std::vector<double>& point_masses() const { return point_masses_; }
  const std::vector<double>& point_damping() const { return point_damping_; }  ///< [1/s]
  const std::vector<BlockScale>& block_scales() const { return block_scales_; }
  const std::vector<JointSide>& joint_sides() const { return joint_sides_; }  ///< two by constraint
  /// By actuator of the scene. In the constraint set they follow the joints.
  const std::vector<ModelActuator>& actuators() const { return actuators_; }
  const std::vector<ModelAttachment>& attachments() const { return attachments_; }  ///< by attachment
  const std::vector<ModelLever>& levers() const { return levers_; }                 ///< by site, ascending
  /// The one at a site; null if it is of something else.
  const ModelLever* find_lever(int32_t site) const;
  const std::vector<HeldPlace>& held_places() const { return held_places_; }  ///< by constraint, ascending
  /// State::held_place at time 0, which is empty in states until one of them is taken anew.
  const std::vector<double>& initial_places() const { return initial_places_; }
  const std::vector<ModelFibres>& fibres() const { return fibres_; }  ///< by fibres of the scene
  /// Position in Energies::batches of an energy of the scene.
  int32_t energy_batch(EnergyId energy) const { return energy_batches_.at(energy.index); }
  const State& initial_state() const { return initial_state_; }
  /// With contact of all pairs that can touch, those of joints and attachments, too.
  ContactSurfaces make_surfaces(const Scene& scene, const Settings& settings) const;
  ContactPotentials contact_potentials() const { return contact_potentials_; }
  /// Of the scene as it was given; states, live values and settings are not among them.
  const std::vector<ModelPart>& parts() const { return parts_; }

  /// [m]
  std::vector<Vec3> site_positions(const State& state) const;
  /// Pose of a rigid body's mesh frame from the state's body frame.
  void mesh_pose(int32_t body, const State& state, Vec3& out_position, Mat3& out_rotation) const;

 private:
  struct Builder;
  std::vector<TangentComponents> make_directions(const Scene& scene) const;
  std::vector<MovingSurface> make_moving(const Scene& scene) const;
  RestitutionTable make_restitution(const Scene& scene, const Settings& settings) const;

  KinematicMap map_;
  std::vector<ModelBody> bodies_;
  std::vector<RigidMass> rigid_masses_;
  std::vector<double> point_masses_;
  std::vector<double> point_damping_;
  std::vector<BlockScale> block_scales_;
  std::vector<int32_t> energy_batches_;  ///< by energy of the scene
  std::vector<JointSide> joint_sides_;
  std::vector<ModelActuator> actuators_;
  std::vector<ModelAttachment> attachments_;
  std::vector<ModelLever> levers_;
  std::vector<HeldPlace> held_places_;
  std::vector<double> initial_places_;
  std::vector<ModelFibres> fibres_;
  std::vector<Vec3> rest_positions_;  ///< by site [m]
  State initial_state_;
  ContactPotentials contact_potentials_;
  std::vector<ModelPart> parts_;
};

}  // namespace stark
