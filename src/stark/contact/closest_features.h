// One contact of a point with each place of a surface, however many triangles meet there (step phase 4b).
//
// A point near an edge is as near to both of its triangles. The energy of a point is therefore the sum over
// triangles, minus that over the edges between them, plus that over vertices, so that every feature counts
// once in sum: with the coefficient 1 of cells (triangles, convex flat faces, edges of rods), an edge of n
// cells has 1 - n and a vertex 1 minus the coefficients of all that meet in it. Terms with the same closest
// feature are merged into one contact with an integer multiplicity. On a flat or convex surface all but the
// nearest cancel; above valleys the nearest point of each side remains, and what both have in common is taken
// away: a negative contact, without which the energy would jump as the point moves along.
// [Li et al. 2023, "Convergent incremental potential contact", section 4.2; the coefficients from the cells
// in range, so that they hold on surfaces with borders, holes and parts without contact; theory eq. 16c]
#pragma once

#include <span>
#include <vector>

#include <stark/contact/contact_set.h>

namespace stark {

/// Border edges of the cells of a surface: of a triangle its three, of a convex flat face those around it.
class SurfaceCells {
 public:
  SurfaceCells() = default;
  /// face: see ContactGeometry.
  SurfaceCells(const SurfaceMesh& mesh, std::span<const int32_t> face);

  /// Edges (low, high) of a cell, which is named by its triangle or the lowest one of its face.
  std::span<const Index2> edges(int32_t cell) const {
    return std::span(edges_).subspan(offsets_[cell], offsets_[cell + 1] - offsets_[cell]);
  }

 private:
  std::vector<int32_t> offsets_;
  std::vector<Index2> edges_;
};

/// Merges contacts `near` as find_contacts() gives them, and drops those between primitives that are
/// prescribed altogether, whose motion no force changes. names: pairs that contacts were known by, sorted; a
/// contact that has slid to the next triangle keeps its name, so that friction remembers it. Sorted by key.
std::vector<Contact> merge_by_feature(const ContactGeometry& geometry, const SurfaceCells& cells,
                                      std::span<const PairKey> names, std::span<const Vec3> x,
                                      std::span<const Contact> near, ThreadPool& pool);

/// Merges pairs of edges that are nearest at the same ends into one with the sum of their stiffness, and
/// drops those that are parallel, which have no energy.
void merge_equal_stencils(std::span<const Vec3> x, std::vector<Contact>& contacts);

}  // namespace stark
