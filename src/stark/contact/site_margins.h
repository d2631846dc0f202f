// How far each site of the surfaces may move from where its pairs were found before they are looked for anew
// (step phases 2, 4b and 4h). All sites are asked several times in every Newton iteration, so they are gone
// through in runs of neighbours, without a branch for each.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <stark/collision/surface_mesh.h>

namespace stark {

class SiteMargins {
 public:
  SiteMargins() = default;
  /// margin: by group [m].
  SiteMargins(const SurfaceMesh& mesh, std::span<const double> margin);

  int64_t site_count() const { return count_; }
  /// Of a site of the surfaces [m].
  double operator()(int32_t site) const { return margin_[site]; }

  /// Whether no site is farther than its margin from where it was at `base`.
  bool cover(std::span<const Vec3> base, std::span<const Vec3> x) const;
  /// Marks the sites that are farther than `part` of their margin from `base`; returns how many.
  int64_t mark_beyond(double part, std::span<const Vec3> base, std::span<const Vec3> x,
                      std::vector<uint8_t>& out) const;
  /// Marks the sites that leave their margin on the straight way from x0 to x1; returns how many. Balls are
  /// convex: what starts and ends in its ball is there all the way.
  int64_t mark_leaving(std::span<const Vec3> base, std::span<const Vec3> x0, std::span<const Vec3> x1,
                       std::vector<uint8_t>& out) const;

 private:
  struct Run {
    int32_t begin, end;
  };

  int64_t count_ = 0;
  std::vector<Run> runs_;        ///< of sites of the surfaces
  std::vector<double> margin_;   ///< by site [m]
  std::vector<double> squared_;  ///< by site [m^2]
};

}  // namespace stark
