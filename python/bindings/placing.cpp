// Bindings of placing: bodies put elsewhere between steps. The Python front end is stark/placing.py.
#include "placing.h"

#include <nanobind/nanobind.h>

#include <stark/sim/placing.h>
#include <stark/sim/simulation.h>

#include "arrays.h"
#include "stepping.h"

namespace stark::bindings {

namespace {

using namespace nb::literals;

Vec3 vector_of(nb::handle object, const char* name) {
  const auto v = array<Column<double>>(object, name, "three numbers");
  if (v.shape(0) != 3)
    throw InvalidArgument(std::string(name) + ": got " + std::to_string(v.shape(0)) + " numbers, need three");
  return {v.data()[0], v.data()[1], v.data()[2]};
}

Mat3 matrix_of(nb::handle object, const char* name) {
  const auto m = array<Rows<double, 3>>(object, name, "a 3x3 matrix");
  if (m.shape(0) != 3) throw InvalidArgument(std::string(name) + ": need a 3x3 matrix");
  Mat3 result;
  std::copy_n(m.data(), 9, result.m.begin());
  return result;
}

}  // namespace

void bind_placing_of_simulation(nb::handle type) {
  nb::borrow<nb::class_<Simulation>>(type)
      .def("begin_placing", &Simulation::begin_placing)
      .def("end_placing", &Simulation::end_placing, "Checks what was placed; puts all back where it fails.")
      .def("cancel_placing", &Simulation::cancel_placing)
      .def_prop_ro("is_placing", &Simulation::is_placing)
      .def_prop_ro(
          "placed_bodies",
          [](const Simulation& s) { return to_numpy<int32_t>(std::vector<int32_t>(s.placed().bodies)); },
          nb::rv_policy::automatic, "Bodies placed since the last step, by number.")
      .def(
          "place",
          [](Simulation& s, int32_t body, nb::object position, nb::object rotation) {
            s.place(BodyId{body}, vector_of(position, "position"), matrix_of(rotation, "rotation"));
          },
          "body"_a, "position"_a, "rotation"_a)
      .def(
          "push",
          [](Simulation& s, int32_t body, nb::object velocity, nb::object angular_velocity) {
            s.push(BodyId{body}, vector_of(velocity, "velocity"),
                   vector_of(angular_velocity, "angular_velocity"));
          },
          "body"_a, "velocity"_a, "angular_velocity"_a)
      .def(
          "place_vertices",
          [](Simulation& s, int32_t body, nb::object positions) {
            const auto x = array<Rows<double, 3>>(positions, "positions", "an (n, 3) array of positions");
            s.place_vertices(BodyId{body}, rows<Vec3>(x));
          },
          "body"_a, "positions"_a)
      .def(
          "push_vertices",
          [](Simulation& s, int32_t body, nb::object velocities) {
            const auto v = array<Rows<double, 3>>(velocities, "velocities", "an (n, 3) array of velocities");
            s.push_vertices(BodyId{body}, rows<Vec3>(v));
          },
          "body"_a, "velocities"_a)
      .def(
          "place_joint",
          [](Simulation& s, int32_t joint, nb::object coordinates) {
            const auto q = array<Column<double>>(coordinates, "coordinates", "numbers");
            s.place_joint({joint}, values(q));
          },
          "joint"_a, "coordinates"_a)
      .def(
          "push_joint",
          [](Simulation& s, int32_t joint, nb::object rates) {
            const auto q = array<Column<double>>(rates, "rates", "numbers");
            s.push_joint({joint}, values(q));
          },
          "joint"_a, "rates"_a);
}

}  // namespace stark::bindings
