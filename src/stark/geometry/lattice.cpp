// See lattice.h.
#include <stark/geometry/lattice.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <stark/base/error.h>
#include <stark/base/settings.h>
#include <stark/geometry/topology.h>
#include <stark/geometry/winding_number.h>

namespace stark {

namespace {

constexpr int64_t kMostCells = 2'000'000;

/// Least part of a cell that counts as filled: vertices in emptier ones would hang on next to nothing.
constexpr double kLeastPart = 0.01;

/// Correction of parts to the exact volume beyond which the surface does not enclose it: it overlaps itself.
constexpr double kLargestCorrection = 0.5;

/// Where the cells are. A cell is known by its place, x fastest.
struct Grid {
  Vec3 origin;
  double size = 0.0;
  Index3 count{};

  int64_t cell_count() const { return int64_t{count[0]} * count[1] * count[2]; }
  int64_t at(const Index3& c) const { return (int64_t{c[2]} * count[1] + c[1]) * count[0] + c[0]; }
  Index3 cell_of(const Vec3& x) const {
    Index3 c;
    for (int k = 0; k < 3; ++k)
      c[k] = std::clamp(static_cast<int32_t>(std::floor((x[k] - origin[k]) / size)), 0, count[k] - 1);
    return c;
  }
  Vec3 corner(const Index3& c) const {
    return origin + Vec3{double(c[0]), double(c[1]), double(c[2])} * size;
  }
};

void check(const TriangleMesh& surface, double cell_size) {
  if (!(cell_size > 0.0) || !std::isfinite(cell_size))
    throw InvalidArgument("lattice: cell_size = " + quantity_text(cell_size, "m") +
                          ": must be > 0 and finite; choose a few cells across the thinnest part");
  if (surface.triangles.empty())
    throw InvalidMesh("lattice: the surface has 0 triangles: must have some; check the file");
  std::vector<char> used(surface.vertices.size(), 0);
  for (const Index3& t : surface.triangles)
    for (const int32_t v : t) {
      if (v < 0 || static_cast<size_t>(v) >= surface.vertices.size())
        throw InvalidMesh("lattice: a triangle refers to vertex " + std::to_string(v) + ": must be in [0, " +
                          std::to_string(surface.vertices.size()) + ")");
      used[v] = 1;
    }
  for (size_t v = 0; v < used.size(); ++v) {
    if (!is_finite(surface.vertices[v]))
      throw InvalidMesh("lattice: vertex " + std::to_string(v) +
                        " is not finite: must be three numbers [m]; check where it is computed");
    if (!used[v])
      throw InvalidMesh("lattice: vertex " + std::to_string(v) +
                        " is in no triangle: must be in one; remove it with stark.mesh.compact(mesh)");
  }
}

Grid grid_around(const TriangleMesh& surface, double cell_size) {
  Vec3 low = surface.vertices[0], high = low;
  for (const Vec3& v : surface.vertices)
    for (int k = 0; k < 3; ++k) low[k] = std::min(low[k], v[k]), high[k] = std::max(high[k], v[k]);
  Grid grid{.size = cell_size};
  double cells = 1.0;
  for (int k = 0; k < 3; ++k) {
    const double wanted = std::max(1.0, std::ceil((high[k] - low[k]) / cell_size * (1.0 - 1e-12)));
    cells *= wanted;
    grid.count[k] = static_cast<int32_t>(std::min(wanted, 1e6));
    grid.origin[k] = 0.5 * (low[k] + high[k]) - 0.5 * cell_size * grid.count[k];
  }
  if (!(cells <= kMostCells))
    throw InvalidArgument("lattice: cell_size = " + quantity_text(cell_size, "m") + " makes " +
                          to_text(cells) + " cells around the surface: must be at most " +
                          std::to_string(kMostCells) + "; use larger cells, and metres");
  return grid;
}

/// Points that fill the unit cube evenly, also seen along its axes: multiples of powers of the root of
/// x^4 = x + 1, modulo one.
std::vector<Vec3> sample_points() {
  const double root = 1.2207440846057596;
  std::vector<Vec3> points(kFillingSamples);
  for (int i = 0; i < kFillingSamples; ++i) {
    double step = 1.0;
    for (int k = 0; k < 3; ++k) {
      step /= root;
      const double x = 0.5 + (i + 1) * step;
      points[i][k] = x - std::floor(x);
    }
  }
  return points;
}

/// Cells that boxes around the triangles reach into.
std::vector<char> cells_at_surface(const Grid& grid, const TriangleMesh& surface) {
  std::vector<char> result(grid.cell_count(), 0);
  for (const Index3& t : surface.triangles) {
    Vec3 low = surface.vertices[t[0]], high = low;
    for (const int32_t v : t)
      for (int k = 0; k < 3; ++k) {
        low[k] = std::min(low[k], surface.vertices[v][k]);
        high[k] = std::max(high[k], surface.vertices[v][k]);
      }
    const Index3 a = grid.cell_of(low), b = grid.cell_of(high);
    for (int32_t z = a[2]; z <= b[2]; ++z)
      for (int32_t y = a[1]; y <= b[1]; ++y)
        for (int32_t x = a[0]; x <= b[0]; ++x) result[grid.at({x, y, z})] = 1;
  }
  return result;
}

void scale(CellFilling& filling, double factor) {
  for (double& m : filling.moments) m *= factor;
}

/// Sums of x^i y^j z^k over points of a cell.
struct Moments {
  std::array<double, 27> sums{};
  double count() const { return sums[0]; }
  void add(const Vec3& x) {
    for (int k = 0; k < 3; ++k)
      for (int j = 0; j < 3; ++j)
        for (int i = 0; i < 3; ++i) sums[i + 3 * j + 9 * k] += power(x.x, i) * power(x.y, j) * power(x.z, k);
  }
  CellFilling filling(double part) const {
    CellFilling result{sums};
    scale(result, part / count());
    return result;
  }
  static double power(double x, int n) { return n == 0 ? 1.0 : n == 1 ? x : x * x; }
};

class Filler {
 public:
  Filler(const TriangleMesh& surface, const Grid& grid)
      : surface_(surface),
        grid_(grid),
        winding_(surface.vertices, surface.triangles),
        samples_(sample_points()),
        at_surface_(cells_at_surface(grid, surface)),
        of_vertices_(grid.cell_count()) {
    for (const Vec3& v : surface.vertices) {
      const Index3 c = grid.cell_of(v);
      of_vertices_[grid.at(c)].add((v - grid.corner(c)) / grid.size);
    }
  }

  /// Nothing: the cell is not needed.
  std::optional<CellFilling> fill(const Index3& cell) {
    const Vec3 corner = grid_.corner(cell);
    const int64_t number = grid_.at(cell);
    if (!at_surface_[number]) {
      if (!is_inside(corner + Vec3{0.5, 0.5, 0.5} * grid_.size)) return {};
      return CellFilling{};
    }
    Moments inside;
    for (const Vec3& s : samples_)
      if (is_inside(corner + s * grid_.size)) inside.add(s);
    if (inside.count() == kFillingSamples) return CellFilling{};
    if (inside.count() > 0.0) return inside.filling(std::max(kLeastPart, inside.count() / kFillingSamples));
    if (of_vertices_[number].count() > 0.0) return of_vertices_[number].filling(kLeastPart);
    return {};
  }

  bool found_inside() const { return largest_ > 0.5; }
  std::string range_text() const { return to_text(smallest_) + " and " + to_text(largest_); }
  bool is_inside_out() const { return smallest_ < -0.5; }

 private:
  bool is_inside(const Vec3& x) {
    const double number = winding_.at(x);
    largest_ = std::max(largest_, number);
    smallest_ = std::min(smallest_, number);
    return number > 0.5;
  }

  const TriangleMesh& surface_;
  const Grid& grid_;
  WindingNumber winding_;
  std::vector<Vec3> samples_;
  std::vector<char> at_surface_;
  std::vector<Moments> of_vertices_;
  double largest_ = 0.0, smallest_ = 0.0;
};

/// Shifts the parts of cells that are neither full nor empty so that they sum to the exact volume, if the
/// surface is closed.
void correct_volume(const TriangleMesh& surface, double cell_volume, std::vector<CellFilling>& fillings) {
  if (!is_closed(surface.triangles) || !is_orientation_consistent(surface.triangles)) return;
  double exact = 0.0;
  const Vec3 from = surface.vertices[0];
  for (const auto& [i, j, k] : surface.triangles)
    exact +=
        dot(surface.vertices[i] - from, cross(surface.vertices[j] - from, surface.vertices[k] - from)) / 6.0;
  double total = 0.0, room = 0.0;
  for (const CellFilling& f : fillings) {
    total += f.part();
    room += f.part() * (1.0 - f.part());
  }
  const double correction = room > 0.0 ? (exact / cell_volume - total) / room : 0.0;
  if (std::fabs(correction) > kLargestCorrection) return;
  for (CellFilling& f : fillings) scale(f, 1.0 + correction * (1.0 - f.part()));
}

void require_inside(const Filler& filler) {
  if (filler.found_inside()) return;
  throw InvalidMesh("lattice: winding numbers of the surface are between " + filler.range_text() +
                    " and nowhere above 0.5: must be so inside; " +
                    (filler.is_inside_out()
                         ? "it is oriented inwards, use mesh.flipped()"
                         : "it is open or oriented differently from place to place, close it with "
                           "stark.mesh.cleaned(mesh)"));
}

}  // namespace

SolidMesh make_lattice(const TriangleMesh& surface, double cell_size, bool quadratic) {
  check(surface, cell_size);
  const Grid grid = grid_around(surface, cell_size);
  Filler filler(surface, grid);
  const auto node = [&](int32_t x, int32_t y, int32_t z) {
    return (int64_t{z} * (grid.count[1] + 1) + y) * (grid.count[0] + 1) + x;
  };
  std::vector<int32_t> element_at(grid.cell_count(), -1);
  std::vector<int32_t> vertex_at(node(0, 0, grid.count[2] + 1), -1);
  SolidMesh mesh;
  mesh.type = ElementType::Hex8;
  for (int32_t z = 0; z < grid.count[2]; ++z)
    for (int32_t y = 0; y < grid.count[1]; ++y)
      for (int32_t x = 0; x < grid.count[0]; ++x) {
        const std::optional<CellFilling> filling = filler.fill({x, y, z});
        if (!filling) continue;
        element_at[grid.at({x, y, z})] = static_cast<int32_t>(mesh.embedding.fillings.size());
        mesh.embedding.fillings.push_back(*filling);
        for (const int32_t k : {z, z + 1})
          for (const auto& [i, j] :
               {Index2{x, y}, Index2{x + 1, y}, Index2{x + 1, y + 1}, Index2{x, y + 1}}) {
            int32_t& v = vertex_at[node(i, j, k)];
            if (v < 0) {
              v = static_cast<int32_t>(mesh.vertices.size());
              mesh.vertices.push_back(grid.corner({i, j, k}));
            }
            mesh.elements.push_back(v);
          }
      }
  require_inside(filler);
  correct_volume(surface, cell_size * cell_size * cell_size, mesh.embedding.fillings);
  Embedding embedding = std::move(mesh.embedding);
  if (quadratic)
    mesh = to_quadratic(SolidMesh(std::move(mesh.vertices), mesh.type, std::move(mesh.elements)));
  const auto first = static_cast<int32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), surface.vertices.begin(), surface.vertices.end());
  for (const Vec3& v : surface.vertices) embedding.elements.push_back(element_at[grid.at(grid.cell_of(v))]);
  for (const auto& [i, j, k] : surface.triangles)
    embedding.triangles.push_back({first + i, first + j, first + k});
  mesh.embedding = std::move(embedding);
  return mesh;
}

}  // namespace stark
