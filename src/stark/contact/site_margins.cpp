// See site_margins.h.
#include <stark/contact/site_margins.h>

#include <algorithm>
#include <cmath>

namespace stark {

namespace {

/// Sites between two looks at whether one has left its margin.
constexpr int32_t kSitesPerLook = 512;

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

SiteMargins::SiteMargins(const SurfaceMesh& mesh) {
  for (const int32_t site : find_surface_sites(mesh)) {
    const int32_t group = mesh.vertex_group[site];
    if (runs_.empty() || runs_.back().end != site || runs_.back().group != group)
      runs_.push_back({site, site, group});
    runs_.back().end = site + 1;
    ++count_;
  }
}

bool SiteMargins::cover(std::span<const double> margin, std::span<const Vec3> base,
                        std::span<const Vec3> x) const {
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

int64_t SiteMargins::mark_beyond(double part, std::span<const double> margin, std::span<const Vec3> base,
                                 std::span<const Vec3> x, std::vector<uint8_t>& out) const {
  out.assign(x.size(), 0);
  int64_t marked = 0;
  for (const Run& run : runs_) {
    const double squared = part * part * margin[run.group] * margin[run.group];
    for (int32_t i = run.begin; i < run.end; ++i) {
      out[i] = is_beyond(x[i], base[i], squared) ? 1 : 0;
      marked += out[i];
    }
  }
  return marked;
}

int64_t SiteMargins::mark_more(std::span<const double> margin, std::span<const Vec3> base,
                               std::span<const Vec3> x, std::span<uint8_t> marked) const {
  int64_t added = 0;
  for (const Run& run : runs_) {
    const double squared = margin[run.group] * margin[run.group];
    for (int32_t i = run.begin; i < run.end; ++i) {
      const bool is_new = marked[i] == 0 && is_beyond(x[i], base[i], squared);
      marked[i] |= is_new ? 1 : 0;
      added += is_new ? 1 : 0;
    }
  }
  return added;
}

int64_t SiteMargins::mark_leaving(std::span<const double> margin, std::span<const Vec3> base,
                                  std::span<const Vec3> x0, std::span<const Vec3> x1,
                                  std::vector<uint8_t>& out) const {
  out.assign(x0.size(), 0);
  int64_t marked = 0;
  for (const Run& run : runs_) {
    const double squared = margin[run.group] * margin[run.group];
    for (int32_t i = run.begin; i < run.end; ++i) {
      const bool starts = is_beyond(x0[i], base[i], squared);
      const bool ends = is_beyond(x1[i], base[i], squared);
      out[i] = static_cast<uint8_t>(static_cast<int>(starts) | static_cast<int>(ends));
      marked += out[i];
    }
  }
  return marked;
}

void SiteMargins::bound(std::span<const Vec3> x, std::span<const uint8_t> marked,
                        std::vector<Bounds>& bounds) const {
  std::vector<uint8_t> has_moved(bounds.size(), 0);
  const auto is_marked = [](uint8_t m) { return m != 0; };
  for (const Run& run : runs_)
    has_moved[run.group] |= std::ranges::any_of(marked.subspan(run.begin, run.end - run.begin), is_marked);
  for (size_t group = 0; group < bounds.size(); ++group)
    if (has_moved[group] != 0) bounds[group] = {};
  for (const Run& run : runs_)
    if (has_moved[run.group] != 0)
      for (int32_t i = run.begin; i < run.end; ++i) bounds[run.group].add(x[i]);
}

}  // namespace stark
