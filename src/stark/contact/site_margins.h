// How far each site of the surfaces may move from where its pairs were found before they are looked for anew
// (step phases 2, 4b and 4h). All sites are asked several times in every Newton iteration, so they are gone
// through in runs of neighbours, without a branch for each. What moves as one piece is asked as a whole, and
// all or none of it is marked, so that what is not marked stays where its frame was found.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <stark/base/thread_pool.h>
#include <stark/collision/bounds.h>
#include <stark/collision/surface_mesh.h>

namespace stark {

/// Where sites are when their pairs are found.
struct SitePlaces {
  std::vector<Vec3> x{};             ///< of sites of surfaces [m]
  std::vector<Bounds> bounds{};      ///< of them, by group
  std::vector<uint64_t> versions{};  ///< by piece: places of the same one are the same
};

/// Margins are by group [m]. Of groups with a frame the corners of their box count, for all sites.
class SiteMargins {
 public:
  SiteMargins() = default;
  /// pool: to ask many pieces; may be null.
  explicit SiteMargins(const SurfaceMesh& mesh, ThreadPool* pool = nullptr);

  int64_t site_count() const { return count_; }

  /// Whether no site is farther than its margin from where it was at `base`.
  bool cover(std::span<const double> margin, std::span<const Vec3> base, std::span<const Vec3> x) const;
  /// Marks the sites that are farther than `part` of their margin from `base`; returns how many.
  int64_t mark_beyond(double part, std::span<const double> margin, std::span<const Vec3> base,
                      std::span<const Vec3> x, std::vector<uint8_t>& out) const;
  /// Marks sites that are beyond their margin from `base`, and leaves those that are marked; returns how
  /// many.
  int64_t mark_more(std::span<const double> margin, std::span<const Vec3> base, std::span<const Vec3> x,
                    std::span<uint8_t> marked) const;
  /// Marks the sites that leave their margin on the straight way from x0 to x1; returns how many. Balls are
  /// convex: what starts and ends in its ball is there all the way.
  int64_t mark_leaving(std::span<const double> margin, std::span<const Vec3> base, std::span<const Vec3> x0,
                       std::span<const Vec3> x1, std::vector<uint8_t>& out) const;

  /// Makes `out`, which has bounds of all groups, the places of `base` but for marked sites, which are at x;
  /// all are where `base` has none. A piece costs nothing where `out` has it there already. version: above 0,
  /// another one for each x.
  void place(const SitePlaces& base, std::span<const uint8_t> marked, std::span<const Vec3> x,
             uint64_t version, SitePlaces& out) const;

 private:
  /// Sites of the surface of a group.
  struct Run {
    int32_t begin, end, group;
  };
  /// A group with a frame, and its runs.
  struct Piece {
    GroupFrame frame;
    int32_t group = 0;
    std::vector<Run> runs{};
  };

  void place_sites(const SitePlaces& base, std::span<const uint8_t> marked, std::span<const Vec3> x,
                   SitePlaces& out) const;
  void copy_piece(const Piece& piece, std::span<const Vec3> x, SitePlaces& out) const;
  /// Marks what was not; returns how many. is_site(run) gives a test of sites.
  template <typename IsSite, typename IsPiece>
  int64_t mark(std::span<uint8_t> out, IsSite&& is_site, IsPiece&& is_piece) const;
  /// Marks more of those that are farther than `part` of their margin from `base`.
  int64_t add_beyond(double part, std::span<const double> margin, std::span<const Vec3> base,
                     std::span<const Vec3> x, std::span<uint8_t> out) const;

  int64_t count_ = 0;
  ThreadPool* pool_ = nullptr;
  std::vector<Run> runs_;      ///< of groups without a frame
  std::vector<Piece> pieces_;  ///< by group
};

}  // namespace stark
