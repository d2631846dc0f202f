// Bindings of attachments. The front end is stark/attachments.
#include "attachments.h"

#include <nanobind/stl/string.h>

#include "formulas.h"
#include "stepping.h"

namespace stark::bindings {

using namespace nb::literals;

int32_t add_attachment(Scene& scene, const nb::dict& given) {
  AttachmentDescription attachment;
  attachment.name = nb::cast<std::string>(given["name"]);
  attachment.a = to_point_set(nb::cast<nb::dict>(given["a"]));
  for (nb::handle points : nb::cast<nb::list>(given["b"]))
    attachment.b.push_back(to_point_set(nb::cast<nb::dict>(points)));
  if (given.contains("patches")) {
    const auto patches = array<Rows<int32_t, 3>>(given["patches"], "patches", "an (n, 3) array of vertices");
    const std::span<const Index3> p = rows<Index3>(patches);
    attachment.patches.assign(p.begin(), p.end());
    attachment.patch_body = {nb::cast<int32_t>(given["patch_body"])};
  }
  attachment.break_force = nb::cast<double>(given["break_force"]);
  attachment.enabled = nb::cast<bool>(given["enabled"]);
  if (given.contains("contact")) attachment.contact = nb::cast<bool>(given["contact"]);
  return scene.add_attachment(std::move(attachment)).index;
}

void bind_attachments_of_scene(nb::handle type) {
  nb::borrow<nb::class_<Scene>>(type)
      .def("add_attachment", &add_attachment, "description"_a, "Glues points; returns the index.")
      .def(
          "attachment_name", [](const Scene& s, int32_t k) { return s.attachment({k}).name; },
          "attachment"_a);
}

void bind_attachments_of_simulation(nb::handle type) {
  nb::borrow<nb::class_<Simulation>>(type)
      .def_prop_ro("attachment_count", [](const Simulation& s) { return s.scene().attachments().size(); })
      .def(
          "attachment_forces",
          [](const Simulation& s, int32_t k) { return to_numpy<double>(s.attachment_forces({k})); },
          "attachment"_a, "On side a in the last step (n, 3) [N].")
      .def(
          "attachment_status",
          [](const Simulation& s, int32_t k) { return to_numpy<int32_t>(s.attachment_status({k})); },
          "attachment"_a, "By pair: 1 held, 0 released, -1 broken.")
      .def(
          "set_attachment_enabled",
          [](Simulation& s, int32_t k, bool enabled) { s.set_attachment_enabled({k}, enabled); },
          "attachment"_a, "enabled"_a);
}

}  // namespace stark::bindings
