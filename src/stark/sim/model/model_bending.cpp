// Bending of the shells of a model: hinges or plates, elastic or yielding, and their damping.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include <stark/geometry/topology.h>
#include <stark/mechanics/plate_element.h>
#include <stark/mechanics/rest_state.h>
#include <stark/models/shells/plate_angles.h>
#include <stark/sim/model/model_builder.h>
#include <stark/sim/scene/material_fields.h>

namespace stark {

namespace models {
PotentialDefinition curling_plate(int hinges);
PotentialDefinition curling_plastic_plate(int hinges);
}  // namespace models

namespace {

/// Stiffness of a hinge: both halves of its width, one in each triangle, carry the same moment.
double in_series(double a, double b) { return a > 0.0 && b > 0.0 ? 2.0 / (1.0 / a + 1.0 / b) : 0.0; }

/// Of the hinges [J].
ParameterValues hinge_stiffness(const ClothDescription& sheet, std::span<const Index4> hinges) {
  FieldValues stiffness{{sheet.material.bending_stiffness}};
  if (sheet.fields.contains("bending_stiffness")) {
    std::map<std::array<int32_t, 3>, double> by_triangle;
    const auto key = [](int32_t a, int32_t b, int32_t c) {
      std::array<int32_t, 3> sorted{a, b, c};
      std::ranges::sort(sorted);
      return sorted;
    };
    for (size_t t = 0; t < sheet.mesh.triangles.size(); ++t) {
      const Index3& v = sheet.mesh.triangles[t];
      by_triangle[key(v[0], v[1], v[2])] = bending_stiffness(sheet, t);
    }
    stiffness = {.values = {}, .per_element = true};
    for (const auto& [a, b, c, d] : hinges)
      stiffness.values.push_back(in_series(by_triangle.at(key(a, b, c)), by_triangle.at(key(a, b, d))));
  }
  return {{"bending_stiffness", std::move(stiffness)}};
}

/// Of the elements of a plate [N m], each that of its triangle.
ParameterValues plate_rigidity(const ClothDescription& sheet, std::span<const PlateElement* const> elements) {
  FieldValues rigidity{{sheet.material.flexural_rigidity}};
  if (sheet.fields.contains("flexural_rigidity")) {
    rigidity = {.values = {}, .per_element = true};
    for (const PlateElement* element : elements)
      rigidity.values.push_back(flexural_rigidity(sheet, static_cast<size_t>(element->triangle)));
  }
  return {{"flexural_rigidity", std::move(rigidity)}};
}

/// Entries of a form over the hinges of an element, as data "form00", "form01", ...
void set_form(PotentialBatch& batch, int64_t e, const std::array<double, 10>& form, int hinges) {
  size_t k = 0;
  for (int i = 0; i < 4; ++i)
    for (int j = i; j < 4; ++j, ++k)
      if (j < hinges) batch.set("form" + std::to_string(i) + std::to_string(j), e, form[k]);
}

void set_rest_angles(PotentialBatch& batch, int64_t e, const PlateElement& element, RestAngles rest) {
  for (int i = 0; i < element.hinge_count; ++i)
    batch.set("rest_angle" + std::to_string(i), e, rest == RestAngles::Flat ? 0.0 : element.rest_angles[i]);
}

void set_yield(PotentialBatch& batch, const BendingYield& yield) {
  batch.set_uniform("bending_yield_moment", yield.moment);
  batch.set_uniform("bending_hardening", yield.hardening);
}

void set_curvature(PotentialBatch& batch, int64_t e, const PlateElement& element) {
  for (int i = 0; i < 3; ++i)
    for (int h = 0; h < element.hinge_count; ++h)
      batch.set("curvature" + std::to_string(i) + std::to_string(h), e, element.curvature[3 * i + h]);
  batch.set("area", e, element.area);
}

PotentialDefinition plate_of(int hinges, bool yields, bool curls) {
  if (curls) return yields ? models::curling_plastic_plate(hinges) : models::curling_plate(hinges);
  switch (hinges) {
    case 1:
      return yields ? models::plastic_plate_1() : models::plate_bending_1();
    case 2:
      return yields ? models::plastic_plate_2() : models::plate_bending_2();
    case 3:
      return yields ? models::plastic_plate_3() : models::plate_bending_3();
    default:
      return models::plate_bending_4();
  }
}

/// Of an element, that of its triangle: 9 numbers each.
void set_natural_curvature(PotentialBatch& batch, int64_t e, const PlateElement& element,
                           std::span<const double> values) {
  batch.set(rest_state::kNaturalCurvature, e, values.subspan(9 * element.triangle, 9));
  for (int h = 0; h < element.hinge_count; ++h)
    batch.set(models::kAngleOfCurvature + std::to_string(h), e, element.angle_of_curvature[h]);
}

}  // namespace

void Model::Builder::add_bending(const ClothDescription& sheet, const ModelBody& body,
                                 const std::string& name) {
  if (sheet.material.flexural_rigidity > 0.0)
    add_plate(sheet, body, name);
  else if (sheet.material.bending_stiffness > 0.0 || sheet.material.bending_damping > 0.0)
    add_hinges(sheet, body, name);
}

void Model::Builder::add_hinges(const ClothDescription& sheet, const ModelBody& body,
                                const std::string& name) {
  const ShellMaterial& material = sheet.material;
  const std::vector<Index4> hinges = find_hinges(sheet.mesh.triangles);
  const std::vector<int32_t> stencils = offset_stencils(hinges, body.first_site);
  const BendingYield yield = bending_yield_of(material);
  const bool flat = sheet.rest_angles == RestAngles::Flat;
  const bool yields = std::isfinite(yield.moment) && material.bending_stiffness > 0.0;
  if (yields) {
    PotentialBatch& bending =
        add_batch(models::plastic_bending(), stencils, name, hinge_stiffness(sheet, hinges));
    const std::vector<Vec3>& X = sheet.mesh.vertices;
    for (size_t e = 0; e < hinges.size(); ++e) {
      const auto [a, b, c, d] = hinges[e];
      bending.set("rest_angle", static_cast<int64_t>(e), flat ? 0.0 : fold_angle(X[a], X[b], X[c], X[d]));
    }
    set_yield(bending, yield);
    if (material.bending_damping == 0.0) return;
  }
  const bool damps = material.bending_damping > 0.0;
  const bool quadratic = flat && !yields;
  PotentialBatch& bending =
      add_batch(!quadratic ? models::discrete_shell_bending()
                : damps    ? models::damped_flat_bending()
                           : models::flat_bending(),
                stencils, name,
                yields ? ParameterValues{{"bending_stiffness", {{0.0}}}} : hinge_stiffness(sheet, hinges));
  if (damps || !quadratic) bending.set_uniform("bending_damping", material.bending_damping);
}

void Model::Builder::add_plate(const ClothDescription& sheet, const ModelBody& body,
                               const std::string& name) {
  const ShellMaterial& material = sheet.material;
  const BendingYield yield = bending_yield_of(material);
  const auto natural = sheet.rest_state.find(rest_state::kNaturalCurvature);
  const bool curls = natural != sheet.rest_state.end();
  const auto elements =
      find_plate_elements(sheet.mesh.vertices, sheet.mesh.triangles, material.poissons_ratio);
  for (int hinges = 1; hinges <= 4; ++hinges) {
    std::vector<const PlateElement*> chosen;
    std::vector<int32_t> stencils;
    for (const PlateElement& element : elements) {
      if (element.hinge_count != hinges) continue;
      chosen.push_back(&element);
      for (int k = 0; k < 3 + hinges; ++k) stencils.push_back(body.first_site + element.vertices[k]);
    }
    if (chosen.empty()) continue;
    const bool yields = std::isfinite(yield.moment) && hinges < 4;
    for (const bool plastic : {true, false}) {  // of what yields the second one is the damping
      if (plastic ? !yields : yields && material.bending_damping == 0.0) continue;
      PotentialBatch& batch = add_batch(plate_of(hinges, plastic, curls), stencils, name,
                                        yields && !plastic ? ParameterValues{{"flexural_rigidity", {{0.0}}}}
                                                           : plate_rigidity(sheet, chosen));
      if (curls) {
        std::vector<int32_t>& triangles = energies.batches.back().subject;
        for (const PlateElement* element : chosen) triangles.push_back(element->triangle);
      }
      for (size_t k = 0; k < chosen.size(); ++k) {
        const auto e = static_cast<int64_t>(k);
        set_rest_angles(batch, e, *chosen[k], sheet.rest_angles);
        set_form(batch, e, plastic ? chosen[k]->remaining_form : chosen[k]->form, hinges);
        if (plastic) set_curvature(batch, e, *chosen[k]);
        if (curls) set_natural_curvature(batch, e, *chosen[k], natural->second.values);
      }
      if (plastic) {
        batch.set_uniform("poissons_ratio", material.poissons_ratio);
        set_yield(batch, yield);
      } else {
        batch.set_uniform("bending_damping", material.bending_damping);
      }
    }
  }
}

}  // namespace stark
