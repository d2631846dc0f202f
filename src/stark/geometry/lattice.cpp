// See lattice.h.
#include <stark/geometry/lattice.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include <stark/base/error.h>
#include <stark/base/settings.h>
#include <stark/base/thread_pool.h>
#include <stark/geometry/topology.h>
#include <stark/geometry/winding_number.h>

namespace stark {

namespace {

constexpr int64_t kMostCells = 2'000'000;

/// Least part of a cell that counts as filled: vertices in emptier ones would hang on next to nothing.
constexpr double kLeastPart = 0.01;

/// How far a vertex may be from a cell that is still its own, in cells: rounding.
constexpr double kRounding = 1e-8;

/// Odds of parts are changed by at most this factor, or its inverse, for the exact volume: less of a part
/// would hold its vertices too loosely.
constexpr double kMostOdds = 4.0;
constexpr int kOddsSteps = 100;

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

/// Winding numbers that were seen.
struct Range {
  double smallest = 0.0, largest = 0.0;
  void add(double number) {
    largest = std::max(largest, number);
    smallest = std::min(smallest, number);
  }
};

class Filler {
 public:
  Filler(const TriangleMesh& surface, const Grid& grid)
      : grid_(grid),
        winding_(surface.vertices, surface.triangles),
        samples_(sample_points()),
        at_surface_(cells_at_surface(grid, surface)) {}

  /// Cells with samples inside, by their place. Each row of cells is a task of its own.
  std::map<int64_t, CellFilling> fill() {
    const int64_t rows = int64_t{grid_.count[1]} * grid_.count[2];
    std::vector<Range> ranges(rows);
    std::vector<std::vector<std::pair<int64_t, CellFilling>>> found(rows);
    ThreadPool pool(usable_threads(0));
    pool.for_each_task(rows, [&](int64_t row, int) {
      Index3 cell{0, static_cast<int32_t>(row % grid_.count[1]), static_cast<int32_t>(row / grid_.count[1])};
      for (; cell[0] < grid_.count[0]; ++cell[0])
        if (const std::optional<CellFilling> filling = fill(cell, ranges[row]))
          found[row].emplace_back(grid_.at(cell), *filling);
    });
    std::map<int64_t, CellFilling> fillings;
    for (int64_t row = 0; row < rows; ++row) {
      fillings.insert(found[row].begin(), found[row].end());
      range_.add(ranges[row].smallest);
      range_.add(ranges[row].largest);
    }
    return fillings;
  }

  bool found_inside() const { return range_.largest > 0.5; }
  /// Some of what is inside is so twice, or the surface is inside out somewhere.
  bool found_overlap() const { return range_.largest > 1.5 || is_inside_out(); }
  std::string range_text() const { return to_text(range_.smallest) + " and " + to_text(range_.largest); }
  bool is_inside_out() const { return range_.smallest < -0.5; }

 private:
  /// Nothing: no sample of the cell is inside.
  std::optional<CellFilling> fill(const Index3& cell, Range& range) const {
    const auto is_inside = [&](const Vec3& x) {
      const double number = winding_.at(x);
      range.add(number);
      return number > 0.5;
    };
    const Vec3 corner = grid_.corner(cell);
    if (!at_surface_[grid_.at(cell)]) {
      if (!is_inside(corner + Vec3{0.5, 0.5, 0.5} * grid_.size)) return {};
      return CellFilling{};
    }
    Moments inside;
    for (const Vec3& s : samples_)
      if (is_inside(corner + s * grid_.size)) inside.add(s);
    if (inside.count() == kFillingSamples) return CellFilling{};
    if (inside.count() > 0.0) return inside.filling(std::max(kLeastPart, inside.count() / kFillingSamples));
    return {};
  }

  const Grid& grid_;
  WindingNumber winding_;
  std::vector<Vec3> samples_;
  std::vector<char> at_surface_;
  Range range_;
};

/// The cell of each vertex. Of those that a vertex on their common face touches, it is the first one that is
/// filled.
std::vector<Index3> cells_of_vertices(const Grid& grid, const TriangleMesh& surface,
                                      const std::map<int64_t, CellFilling>& fillings) {
  std::vector<Index3> result;
  const auto is_filled = [&](const Index3& cell) { return fillings.contains(grid.at(cell)); };
  const auto nudged = [&](const Vec3& v, int corner) {
    const double by = kRounding * grid.size;
    return v + Vec3{corner & 1 ? by : -by, corner & 2 ? by : -by, corner & 4 ? by : -by};
  };
  for (const Vec3& v : surface.vertices) {
    Index3 cell = grid.cell_of(v);
    for (int corner = 0; corner < 8 && !is_filled(cell); ++corner)
      if (const Index3 other = grid.cell_of(nudged(v, corner)); is_filled(other)) cell = other;
    result.push_back(cell);
  }
  return result;
}

/// Cells without a sample inside that hold vertices: they count as filled where those are.
void fill_at_vertices(const Grid& grid, const TriangleMesh& surface, const std::vector<Index3>& of_vertices,
                      std::map<int64_t, CellFilling>& fillings) {
  std::map<int64_t, Moments> found;
  for (size_t v = 0; v < of_vertices.size(); ++v)
    if (const int64_t cell = grid.at(of_vertices[v]); !fillings.contains(cell))
      found[cell].add((surface.vertices[v] - grid.corner(of_vertices[v])) / grid.size);
  for (const auto& [cell, moments] : found) fillings.emplace(cell, moments.filling(kLeastPart));
}

bool encloses_a_volume(const TriangleMesh& surface) {
  return is_closed(surface.triangles) && is_orientation_consistent(surface.triangles);
}

double enclosed_volume(const TriangleMesh& surface) {
  double volume = 0.0;
  const Vec3 from = surface.vertices[0];
  for (const auto& [i, j, k] : surface.triangles)
    volume +=
        dot(surface.vertices[i] - from, cross(surface.vertices[j] - from, surface.vertices[k] - from)) / 6.0;
  return volume;
}

/// Multiplies the odds p / (1 - p) of the parts p that are neither full nor empty by one factor, with which
/// they sum to the volume [cells]. Small changes are in proportion to p (1 - p).
void correct_volume(double volume, std::vector<CellFilling>& fillings) {
  const auto changed = [](double part, double odds) { return odds * part / (1.0 - part + odds * part); };
  double low = -std::log(kMostOdds), high = std::log(kMostOdds);
  for (int step = 0; step < kOddsSteps; ++step) {
    const double middle = 0.5 * (low + high), odds = std::exp(middle);
    double total = 0.0;
    for (const CellFilling& f : fillings) total += changed(f.part(), odds);
    (total < volume ? low : high) = middle;
  }
  const double odds = std::exp(0.5 * (low + high));
  for (CellFilling& f : fillings)
    if (!f.is_full()) scale(f, changed(f.part(), odds) / f.part());
}

void require_inside(const Filler& filler, const TriangleMesh& surface, double cell_size) {
  if (filler.found_inside()) return;
  if (!filler.is_inside_out() && encloses_a_volume(surface) && enclosed_volume(surface) > 0.0)
    throw InvalidMesh("lattice: cell_size = " + quantity_text(cell_size, "m") + ": none of the " +
                      std::to_string(kFillingSamples) +
                      " samples of each cell is inside of the surface: must be so in some; it is much "
                      "thinner than a cell, use smaller cells");
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
  std::map<int64_t, CellFilling> fillings = filler.fill();
  require_inside(filler, surface, cell_size);
  const std::vector<Index3> of_vertices = cells_of_vertices(grid, surface, fillings);
  fill_at_vertices(grid, surface, of_vertices, fillings);

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
        const auto filling = fillings.find(grid.at({x, y, z}));
        if (filling == fillings.end()) continue;
        element_at[filling->first] = static_cast<int32_t>(mesh.embedding.fillings.size());
        mesh.embedding.fillings.push_back(filling->second);
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
  if (encloses_a_volume(surface) && !filler.found_overlap())
    correct_volume(enclosed_volume(surface) / (cell_size * cell_size * cell_size), mesh.embedding.fillings);
  Embedding embedding = std::move(mesh.embedding);
  if (quadratic)
    mesh = to_quadratic(SolidMesh(std::move(mesh.vertices), mesh.type, std::move(mesh.elements)));
  const auto first = static_cast<int32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), surface.vertices.begin(), surface.vertices.end());
  for (const Index3& cell : of_vertices) embedding.elements.push_back(element_at[grid.at(cell)]);
  for (const auto& [i, j, k] : surface.triangles)
    embedding.triangles.push_back({first + i, first + j, first + k});
  mesh.embedding = std::move(embedding);
  return mesh;
}

}  // namespace stark
