// How much surface a contact stands for, so that pressure times area is the same on every mesh (step phase
// 4b).
//
// Triangles give a third of their rest area to each vertex and edge, so do flat faces of rigid bodies that
// have vertices inside, whose border edges share what its vertices have. Faces without give theirs to the
// vertices and edges of their border, by length. What counts against a normal n is the part of the share that
// faces it, max(sum a_t (n_t . n)+, sum a_t (n_t . n)-): at the corner of a box on a floor a quarter of its
// lower face. Sheets and rods have the whole share whatever the normal. Two surfaces see each place from both
// sides; the finer mesh integrates: side A has the part s_A = l_B^8 / (l_A^8 + l_B^8) with the lengths l of
// the meshes, half for equal ones. Pairs of edges have theirs whatever the surfaces' shape; how near they
// must be depends on it (edge_ranges.h). [theory eq. 16a, 16b; Li et al. 2023, section 4.1]
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include <stark/contact/contact_set.h>
#include <stark/contact/edge_ranges.h>

namespace stark {

class AreaWeights {
 public:
  AreaWeights() = default;
  /// patch: by triangle the lowest of its flat face; none: each is one. is_sheet: by group, 1 for surfaces
  /// with two sides; none: closed ones. group_distance: the radius of rods [m].
  AreaWeights(const SurfaceMesh& mesh, std::span<const Vec3> rest, std::span<const int32_t> patch,
              std::span<const uint8_t> is_sheet, std::span<const double> group_distance);

  /// Area [m^2] that the first primitive of a point-triangle, point-edge or point-point contact, or both
  /// edges of an edge pair, stand for against the unit normal n at site positions x.
  double area(const SurfaceMesh& mesh, const Contact& contact, const Vec3& n, std::span<const Vec3> x) const;
  EdgeRanges edge_ranges(const SurfaceMesh& mesh) const;
  /// Whether the area of a point of this group depends on the normal.
  bool is_directed(int32_t group) const { return is_sheet_.empty() || is_sheet_[group] == 0; }
  /// Whether that of a contact does.
  bool is_directed(const Contact& contact) const;

 private:
  /// Part of a triangle's area, by its normal.
  struct Share {
    int32_t triangle;
    double area;  ///< [m^2]
  };
  struct Shares {
    std::vector<int32_t> offsets;
    std::vector<Share> entries;
    std::vector<double> whole;   ///< whatever the normal, also of what has no triangles [m^2]
    std::vector<double> across;  ///< of edges, for rods that lie across them, whatever the normal [m^2]
    std::vector<double> weight;  ///< of vertices the least: 1 sharp, less where it is flat
    void collect(size_t count, std::span<const std::pair<int32_t, Share>> shares);
    std::span<const Share> of(int32_t i) const {
      return std::span(entries).subspan(offsets[i], offsets[i + 1] - offsets[i]);
    }
  };

  void share_triangles(const SurfaceMesh& mesh, std::span<const Vec3> rest, std::span<const int32_t> patch);
  void share_rods(const SurfaceMesh& mesh, std::span<const Vec3> rest, std::span<const double> radius);
  void weigh(const SurfaceMesh& mesh, std::span<const Vec3> rest);
  bool is_border(const SurfaceMesh& mesh, int32_t v) const;  ///< of a sheet
  double vertex_sharpness(const SurfaceMesh& mesh, std::span<const Vec3> rest, int32_t v) const;
  double edge_sharpness(const SurfaceMesh& mesh, std::span<const Vec3> rest, int32_t e) const;
  double area_across(const SurfaceMesh& mesh, std::span<const Vec3> rest, int32_t e) const;
  bool is_rod(int32_t edge) const { return edges_.of(edge).empty(); }
  double area(const SurfaceMesh& mesh, const Shares& shares, int32_t i, int32_t group, const Vec3& n,
              std::span<const Vec3> x) const;
  /// Part of the contact of two groups that is integrated on the first.
  double part(int32_t group, int32_t other) const { return part_[group * cell_area_.size() + other]; }

  std::vector<uint8_t> is_sheet_;
  Shares vertices_, edges_;
  std::vector<double> flatness_;   ///< of edges: 0 sharp, 1 flat
  std::vector<double> cell_area_;  ///< by group: of the mesh, weighted by area [m^2]
  std::vector<double> part_;       ///< by two groups
};

}  // namespace stark
