// Elements whose energy is a sum over quadrature points: E = sum_q w_q psi(F_q) with F_q = sum_a x_a (x)
// G_qa. The law is evaluated in F, nine unknowns whatever the element, with lanes = quadrature points; the
// gradients of the shape functions G bring its derivatives to the nodes (step phase 4c and 4e). [theory
// eq. 10a]
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <stark/mechanics/constitutive_law.h>
#include <stark/mechanics/field_values.h>
#include <stark/mechanics/mean_dilatation.h>
#include <stark/mechanics/potential_batch.h>

namespace stark {

/// Elements that are evaluated together: their quadrature points fill whole blocks of lanes.
inline constexpr int64_t kGroupElements = symbolic::kLanes;

class QuadratureBatch {
 public:
  /// `law`: compiled quadrature_point(), or a sum of them.
  QuadratureBatch(std::shared_ptr<const Potential> law, int node_count, int points_per_element);
  /// Elements of mean dilatation; `law`: compiled mean_dilatation_point().
  QuadratureBatch(std::shared_ptr<const Potential> law, int node_count, int points_per_element,
                  MeanDilatation dilatation);

  int node_count() const { return node_count_; }
  int points_per_element() const { return points_; }
  int64_t size() const { return size_; }
  int64_t group_count() const { return (size_ + kGroupElements - 1) / kGroupElements; }
  /// The law at all quadrature points, element by element.
  const PotentialBatch& law() const { return law_; }
  /// Of elements of mean dilatation, nullptr otherwise.
  const MeanDilatation* dilatation() const { return dilatation_ ? &*dilatation_ : nullptr; }
  /// Numbers that evaluate() writes for each point.
  int output_count(symbolic::Order order) const {
    return dilatation_ ? MeanDilatation::output_count(order) : law_.potential().kernel().output_count(order);
  }

  /// Replaces all elements; stencils is [count][node_count] sites of points.
  void resize(std::span<const int32_t> stencils);
  std::span<const int32_t> stencils() const { return stencils_; }
  std::span<const int32_t> stencil(int64_t element) const {
    return {stencils_.data() + element * node_count_, static_cast<size_t>(node_count_)};
  }

  /// gradients: [points_per_element][node_count] rest gradients of the shape functions [1/m]; weights:
  /// [points_per_element] volumes [m^3]; positions: of the points at rest [m], for mean dilatation only.
  void set_geometry(int64_t element, std::span<const Vec3> gradients, std::span<const double> weights,
                    std::span<const Vec3> positions = {});
  /// Parameters of the law, one for all elements or one for each, as set_values() of a PotentialBatch.
  void set_values(const ParameterValues& values);
  void set_previous(std::span<const Vec3> x_prev);  ///< by site [m]
  void set_beyond(std::span<const Vec3> x_beyond);  ///< by site [m]
  void set_time(double h, double time) { law_.set_time(h, time); }
  /// Internal variables as those of a PotentialBatch, by quadrature point.
  void set_internal(std::span<const double> values) { law_.set_internal(values); }
  std::vector<double> internal_values() const { return law_.internal_values(); }
  std::vector<double> updated_internal(std::span<const Vec3> x) const;
  /// Energies of all quadrature points with nodes at x [J].
  std::vector<double> energies(std::span<const Vec3> x) const;

  /// Of elements of mean dilatation, the volume ratio that the law sees: four numbers for each element, at
  /// X = 0 and slopes in the rest position X. Empty for others.
  std::vector<double> volume_ratios(std::span<const Vec3> x) const;

  /// Column j of F at a point with nodes at x.
  Vec3 column(int64_t element, int point, int j, std::span<const Vec3> x) const;
  /// Gradients of an element at a point, [3 directions][padded_nodes()], zero beyond the nodes.
  const double* gradients(int64_t element, int point) const {
    return gradients_.data() + (element * points_ + point) * 3 * padded_nodes();
  }
  int padded_nodes() const { return (node_count_ + 3) / 4 * 4; }

  /// Evaluates the law at the points of groups [first, last) for nodes at x. out: [(last - first)
  /// points_per_element][output_count][kLanes]; those past the last element repeat the last point. Energy and
  /// derivatives in F; those of mean dilatation: see there.
  void evaluate(symbolic::Order order, std::span<const Vec3> x, int64_t first, int64_t last,
                double* out) const;
  /// Blocks of lanes that groups [0, group) have; the last group may have fewer than points_per_element.
  int64_t block_of_group(int64_t group) const { return std::min(group * points_, law_.block_count()); }

 private:
  /// Points of the law: columns of F and, of mean dilatation, the volume ratio.
  std::vector<Vec3> columns(std::span<const Vec3> x) const;
  /// Points of the law for all quadrature points if it uses a field of the source, nothing otherwise.
  std::vector<Vec3> columns_for(ElementField::Source source, std::span<const Vec3> x) const;

  int node_count_ = 0, points_ = 0;
  int64_t size_ = 0;
  PotentialBatch law_;
  std::optional<MeanDilatation> dilatation_;
  std::vector<int32_t> stencils_;
  AlignedVector<double> gradients_;
};

/// As that of a PotentialBatch.
inline void set_values(QuadratureBatch& batch, const ParameterValues& values) { batch.set_values(values); }

}  // namespace stark
