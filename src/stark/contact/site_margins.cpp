// See site_margins.h.
#include <stark/contact/site_margins.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include <stark/base/for_each_range.h>

namespace stark {

namespace {

/// Sites between two looks at whether one has left its margin.
constexpr int32_t kSitesPerLook = 512;

constexpr int64_t kPiecesPerTask = 32, kSitesPerTask = 8192;

/// Half an edge of a cube over the radius of the ball around it, and a little less.
constexpr double kCube = 0.577;

std::vector<int32_t> find_surface_sites(const SurfaceMesh& mesh) {
  std::vector<int32_t> sites(mesh.points);
  for (const Index2& edge : mesh.edges) sites.insert(sites.end(), edge.begin(), edge.end());
  for (const Index3& triangle : mesh.triangles) sites.insert(sites.end(), triangle.begin(), triangle.end());
  std::ranges::sort(sites);
  sites.erase(std::ranges::unique(sites).begin(), sites.end());
  return sites;
}

/// Whether no component of a displacement is above `most` [m]: a loop over plain numbers, which compilers
/// make several times as fast as one over distances.
bool is_within_cube(const Vec3* base, const Vec3* x, int32_t count, double most) {
  static_assert(sizeof(Vec3) == 3 * sizeof(double));
  const double *a = &base->x, *b = &x->x;
  int64_t above = 0;
  for (int32_t k = 0; k < 3 * count; ++k) above |= !(std::fabs(b[k] - a[k]) <= most) ? 1 : 0;
  return above == 0;
}

/// Also where a position is NaN.
bool is_beyond(const Vec3& a, const Vec3& b, double squared) { return !(squared_norm(a - b) <= squared); }

}  // namespace

SiteMargins::SiteMargins(const SurfaceMesh& mesh, ThreadPool* pool) : pool_(pool) {
  std::vector<Run> all;
  for (const int32_t site : find_surface_sites(mesh)) {
    const int32_t group = mesh.vertex_group[site];
    if (all.empty() || all.back().end != site || all.back().group != group)
      all.push_back({site, site, group});
    all.back().end = site + 1;
    ++count_;
  }
  std::ranges::stable_sort(all, {}, &Run::group);
  for (const Run& run : all) {
    const GroupFrame* frame = mesh.frame_of(run.group);
    if (frame == nullptr) {
      runs_.push_back(run);
      continue;
    }
    if (pieces_.empty() || pieces_.back().group != run.group) pieces_.push_back({*frame, run.group});
    pieces_.back().runs.push_back(run);
  }
}

bool SiteMargins::cover(std::span<const double> margin, std::span<const Vec3> base,
                        std::span<const Vec3> x) const {
  for (const Piece& piece : pieces_)
    if (!(piece.frame.farthest(base, x) <= margin[piece.group])) return false;
  for (const Run& run : runs_) {
    const double squared = margin[run.group] * margin[run.group];
    for (int32_t begin = run.begin; begin < run.end; begin += kSitesPerLook) {
      const int32_t end = std::min(begin + kSitesPerLook, run.end);
      // A cube within the ball.
      if (is_within_cube(&base[begin], &x[begin], end - begin, kCube * margin[run.group])) continue;
      int64_t beyond = 0;
      for (int32_t i = begin; i < end; ++i) beyond |= is_beyond(x[i], base[i], squared) ? 1 : 0;
      if (beyond != 0) return false;
    }
  }
  return true;
}

template <typename IsSite, typename IsPiece>
int64_t SiteMargins::mark(std::span<uint8_t> out, IsSite&& is_site, IsPiece&& is_piece) const {
  int64_t added = 0;
  for (const Run& run : runs_) {
    const auto is_wanted = is_site(run);
    for (int32_t i = run.begin; i < run.end; ++i) {
      const bool is_new = out[i] == 0 && is_wanted(i);
      out[i] |= is_new ? 1 : 0;
      added += is_new ? 1 : 0;
    }
  }
  // Each piece has sites of its own, far from each other in memory.
  std::vector<int64_t> added_of(pieces_.size(), 0);
  for_each_range(pool_, std::ssize(pieces_), kPiecesPerTask, [&](int64_t begin, int64_t end) {
    for (int64_t k = begin; k < end; ++k) {
      const Piece& piece = pieces_[k];
      if (out[piece.runs[0].begin] != 0 || !is_piece(piece)) continue;
      for (const Run& run : piece.runs) {
        std::fill(out.begin() + run.begin, out.begin() + run.end, 1);
        added_of[k] += run.end - run.begin;
      }
    }
  });
  return std::reduce(added_of.begin(), added_of.end(), added);
}

int64_t SiteMargins::add_beyond(double part, std::span<const double> margin, std::span<const Vec3> base,
                                std::span<const Vec3> x, std::span<uint8_t> out) const {
  return mark(
      out,
      [&](const Run& run) {
        return [&, squared = part * part * margin[run.group] * margin[run.group]](int32_t i) {
          return is_beyond(x[i], base[i], squared);
        };
      },
      [&](const Piece& piece) { return !(piece.frame.farthest(base, x) <= part * margin[piece.group]); });
}

int64_t SiteMargins::mark_beyond(double part, std::span<const double> margin, std::span<const Vec3> base,
                                 std::span<const Vec3> x, std::vector<uint8_t>& out) const {
  out.assign(x.size(), 0);
  return add_beyond(part, margin, base, x, out);
}

int64_t SiteMargins::mark_more(std::span<const double> margin, std::span<const Vec3> base,
                               std::span<const Vec3> x, std::span<uint8_t> marked) const {
  return add_beyond(1.0, margin, base, x, marked);
}

int64_t SiteMargins::mark_leaving(std::span<const double> margin, std::span<const Vec3> base,
                                  std::span<const Vec3> x0, std::span<const Vec3> x1,
                                  std::vector<uint8_t>& out) const {
  out.assign(x0.size(), 0);
  return mark(
      out,
      [&](const Run& run) {
        return [&, squared = margin[run.group] * margin[run.group]](int32_t i) {
          return is_beyond(x0[i], base[i], squared) | is_beyond(x1[i], base[i], squared);
        };
      },
      [&](const Piece& piece) {
        const double most = margin[piece.group];
        return !(piece.frame.farthest(base, x0) <= most) || !(piece.frame.farthest(base, x1) <= most);
      });
}

void SiteMargins::place(const SitePlaces& base, std::span<const uint8_t> marked, std::span<const Vec3> x,
                        uint64_t version, SitePlaces& out) const {
  out.x.resize(x.size());
  out.versions.resize(pieces_.size());
  place_sites(base, marked, x, out);
  for_each_range(pool_, std::ssize(pieces_), kPiecesPerTask, [&](int64_t begin, int64_t end) {
    for (int64_t k = begin; k < end; ++k) {
      const Piece& piece = pieces_[k];
      const bool is_marked = marked[piece.runs[0].begin] != 0;
      const uint64_t wanted = is_marked ? version : base.versions[k];
      if (out.versions[k] == wanted) continue;
      out.versions[k] = wanted;
      copy_piece(piece, is_marked ? x : base.x, out);
    }
  });
}

void SiteMargins::place_sites(const SitePlaces& base, std::span<const uint8_t> marked,
                              std::span<const Vec3> x, SitePlaces& out) const {
  std::vector<uint8_t> has_moved(out.bounds.size(), 0);
  const bool is_other = &out != &base && !base.x.empty();
  for (const Run& run : runs_) {
    if (is_other) out.bounds[run.group] = base.bounds[run.group];
    for_each_range(pool_, run.end - run.begin, kSitesPerTask, [&](int64_t first, int64_t last) {
      for (int64_t i = run.begin + first; i < run.begin + last; ++i)
        if (marked[i] != 0)
          out.x[i] = x[i];
        else if (is_other)
          out.x[i] = base.x[i];
    });
    const std::span<const uint8_t> marks = marked.subspan(run.begin, run.end - run.begin);
    has_moved[run.group] |= std::ranges::any_of(marks, [](uint8_t mark) { return mark != 0; });
  }
  for (size_t group = 0; group < out.bounds.size(); ++group)
    if (has_moved[group] != 0) out.bounds[group] = {};
  for (const Run& run : runs_)
    for (int32_t i = run.begin; i < run.end && has_moved[run.group] != 0; ++i)
      out.bounds[run.group].add(out.x[i]);
}

void SiteMargins::copy_piece(const Piece& piece, std::span<const Vec3> x, SitePlaces& out) const {
  Bounds bounds;
  for (const Run& run : piece.runs)
    for (int32_t i = run.begin; i < run.end; ++i) bounds.add(out.x[i] = x[i]);
  out.bounds[piece.group] = bounds;
}

}  // namespace stark
