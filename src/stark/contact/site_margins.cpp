// See site_margins.h.
#include <stark/contact/site_margins.h>

#include <algorithm>

namespace stark {

namespace {

/// Sites between two looks at whether one has left its margin.
constexpr int32_t kSitesPerLook = 512;

std::vector<int32_t> find_surface_sites(const SurfaceMesh& mesh) {
  std::vector<int32_t> sites(mesh.points);
  for (const Index2& edge : mesh.edges) sites.insert(sites.end(), edge.begin(), edge.end());
  for (const Index3& triangle : mesh.triangles) sites.insert(sites.end(), triangle.begin(), triangle.end());
  std::ranges::sort(sites);
  sites.erase(std::ranges::unique(sites).begin(), sites.end());
  return sites;
}

/// Also where a position is NaN.
bool is_beyond(const Vec3& a, const Vec3& b, double squared) { return !(squared_norm(a - b) <= squared); }

}  // namespace

SiteMargins::SiteMargins(const SurfaceMesh& mesh, std::span<const double> margin)
    : margin_(mesh.vertex_group.size(), 0.0), squared_(margin_.size(), 0.0) {
  for (const int32_t site : find_surface_sites(mesh)) {
    margin_[site] = margin[mesh.vertex_group[site]];
    squared_[site] = margin_[site] * margin_[site];
    if (runs_.empty() || runs_.back().end != site) runs_.push_back({site, site});
    runs_.back().end = site + 1;
    ++count_;
  }
}

bool SiteMargins::cover(std::span<const Vec3> base, std::span<const Vec3> x) const {
  for (const Run& run : runs_)
    for (int32_t begin = run.begin; begin < run.end; begin += kSitesPerLook) {
      const int32_t end = std::min(begin + kSitesPerLook, run.end);
      int64_t beyond = 0;
      for (int32_t i = begin; i < end; ++i) beyond |= is_beyond(x[i], base[i], squared_[i]) ? 1 : 0;
      if (beyond != 0) return false;
    }
  return true;
}

int64_t SiteMargins::mark_beyond(double part, std::span<const Vec3> base, std::span<const Vec3> x,
                                 std::vector<uint8_t>& out) const {
  out.assign(x.size(), 0);
  int64_t marked = 0;
  for (const Run& run : runs_)
    for (int32_t i = run.begin; i < run.end; ++i) {
      out[i] = is_beyond(x[i], base[i], part * part * squared_[i]) ? 1 : 0;
      marked += out[i];
    }
  return marked;
}

int64_t SiteMargins::mark_leaving(std::span<const Vec3> base, std::span<const Vec3> x0,
                                  std::span<const Vec3> x1, std::vector<uint8_t>& out) const {
  out.assign(x0.size(), 0);
  int64_t marked = 0;
  for (const Run& run : runs_)
    for (int32_t i = run.begin; i < run.end; ++i) {
      const bool starts = is_beyond(x0[i], base[i], squared_[i]);
      const bool ends = is_beyond(x1[i], base[i], squared_[i]);
      out[i] = static_cast<uint8_t>(static_cast<int>(starts) | static_cast<int>(ends));
      marked += out[i];
    }
  return marked;
}

}  // namespace stark
