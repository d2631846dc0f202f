#include "descriptions.h"

#include "solid_mesh.h"

namespace stark::bindings {

template <>
PointKind read(nb::handle kind, const std::string& name, const std::string&) {
  const auto given = nb::cast<std::string>(kind);
  const std::string subject = name + " = '" + given + "'";
  return choice_of<PointKind>(given.starts_with("node_") ? given.substr(5) : given, subject);
}

template <>
PointSet read(nb::handle entries, const std::string&, const std::string&) {
  const Given given(entries, "points");
  const auto points = given.description<PointSet>();
  given.require("kind");
  if (points.kind == PointKind::Embedded)
    given.require("supports", "weights");
  else
    given.require(points.kind == PointKind::Vertices ? "vertices"
                  : points.kind == PointKind::Joined ? "parts"
                                                     : "local");
  return points;
}

template <>
FrameDescription read(nb::handle entries, const std::string&, const std::string&) {
  const Given given(entries, "frame");
  auto frame = given.description<FrameDescription>();
  given.require("carrier", "rotation");
  if (frame.carrier == FrameDescription::Carrier::Patch) given.require("vertices");
  if (const nb::object node = given.find("node")) frame.vertices = {nb::cast<int32_t>(node), -1, -1};
  return frame;
}

template <>
CoordinateName read(nb::handle pair, const std::string&, const std::string&) {
  return {nb::cast<JointId>(pair[0]), nb::cast<std::string>(pair[1])};
}

template <>
RigidInertia read(nb::handle parts, const std::string& name, const std::string&) {
  return {read<double>(parts[0], name + ".mass"), read<Vec3>(parts[1], name + ".center_of_mass"),
          read<Mat3>(parts[2], name + ".tensor")};
}

void read_rest(const Given& given, SolidDescription& solid) {
  given.read("vertices", solid.mesh.vertices);
  read_elements(given["elements"], given.owner() + ": elements", solid.mesh);
  if (const nb::object embedding = given.find("embedding"))
    solid.mesh.embedding = embedding_of(embedding, given.owner());
}

void read_rest(const Given& given, FibresDescription& fibres) {
  std::vector<int32_t> all, counts;
  given.read("vertices", all, "a row of vertex indices");
  given.read("counts", counts);
  auto next = all.begin();
  for (const int32_t count : counts) {
    fibres.paths.emplace_back(next, next + count);
    next += count;
  }
}

void read_rest(const Given& given, EnergyDescription& energy) {
  std::string name, doc;
  given.read("formula_name", name);
  given.read("doc", doc);
  energy.potential = define_potential(name, doc, nb::cast<Formula>(given["formula"]));
  given.read("translation_invariant", energy.potential.translation_invariant);
}

}  // namespace stark::bindings
