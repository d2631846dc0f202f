// See embedded_assembly.h.
#include <stark/mechanics/embedded_assembly.h>

#include <algorithm>

namespace stark {

namespace {

/// How one block moves a site: by weight * I, or by -[r]x of its lever.
struct Term {
  int32_t block;
  double weight;
  const Vec3* lever;  ///< nullptr: moved along
};

void append_terms(const SiteJacobian& jacobian, std::vector<Term>& out) {
  out.clear();
  for (size_t k = 0; k < jacobian.support_blocks.size(); ++k)
    if (jacobian.support_blocks[k] != kNoBlock && jacobian.support_weights[k] != 0.0)
      out.push_back({jacobian.support_blocks[k], jacobian.support_weights[k], nullptr});
  for (int k = 0; k < jacobian.term_count; ++k) {
    const JacobianTerm& term = jacobian.terms[k];
    out.push_back({term.block, term.weight, term.is_rotation ? &jacobian.lever : nullptr});
  }
}

/// Adds weight * H, transposed where the block pair is the one that is not stored.
void add_block(BlockMatrix& hessian, const Term& a, const Mat3& H, const Term& b) {
  const bool is_upper = a.block <= b.block;
  const int64_t slot = hessian.pattern.slot(is_upper ? a.block : b.block, is_upper ? b.block : a.block);
  double* values = hessian.values.data() + 9 * slot;
  const double weight = a.weight * b.weight;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) values[3 * i + j] += weight * (is_upper ? H(i, j) : H(j, i));
}

}  // namespace

void SitePairs::add(int32_t p, int32_t q, const Mat3& H) {
  const bool in_order = p <= q;
  const int32_t first = in_order ? p : q, second = in_order ? q : p;
  const uint64_t key = (static_cast<uint64_t>(first) << 32) | static_cast<uint32_t>(second);
  const auto [place, is_new] = places_.try_emplace(key, pairs_.size());
  if (is_new) pairs_.push_back({first, second, Mat3{}});
  Mat3& sum = pairs_[place->second].H;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) sum(i, j) += in_order ? H(i, j) : H(j, i);
}

void SitePairs::scatter(const KinematicMap& map, const Configuration& configuration, BlockMatrix& hessian) {
  std::vector<Term> of_p, of_q;
  for (const Pair& pair : pairs_) {
    const SiteJacobian p = map.jacobian(pair.p, configuration), q = map.jacobian(pair.q, configuration);
    append_terms(p, of_p);
    append_terms(q, of_q);
    for (const Term& a : of_p)
      for (const Term& b : of_q) {
        if (pair.p == pair.q && a.block > b.block) continue;  // the transposed pair adds it
        Mat3 H = pair.H;
        if (a.lever) H = skew(*a.lever) * H;
        if (b.lever) H = H * skew(-*b.lever);
        add_block(hessian, a, H, b);
        // A diagonal block has both orders of two different sites.
        if (pair.p != pair.q && a.block == b.block) add_block(hessian, a, transpose(H), b);
      }
  }
  pairs_.clear();
  places_.clear();
}

void SupportPairs::add(std::span<const int32_t> stencil) {
  const int32_t first_support = map_.layout().block_count;
  of_stencil_.clear();
  for (const int32_t site : stencil) {
    if (map_.is_embedded(site)) {
      of_stencil_.push_back(first_support + map_.support_index(site));
      continue;
    }
    blocks_.clear();
    map_.append_blocks(site, blocks_);
    of_stencil_.insert(of_stencil_.end(), blocks_.begin(), blocks_.end());
  }
  std::ranges::sort(of_stencil_);
  of_stencil_.erase(std::unique(of_stencil_.begin(), of_stencil_.end()), of_stencil_.end());
  for (size_t a = 0; a < of_stencil_.size(); ++a)
    for (size_t b = a; b < of_stencil_.size(); ++b) groups_.emplace_back(of_stencil_[a], of_stencil_[b]);
}

std::span<const int32_t> SupportPairs::blocks_of(int32_t group, int32_t& storage) const {
  const int32_t first_support = map_.layout().block_count;
  if (group >= first_support) return map_.support_blocks(group - first_support);
  storage = group;
  return {&storage, 1};
}

void SupportPairs::append_to(std::vector<std::pair<int32_t, int32_t>>& out) {
  std::ranges::sort(groups_);
  groups_.erase(std::unique(groups_.begin(), groups_.end()), groups_.end());
  int32_t of_first = 0, of_second = 0;
  for (const auto& [first, second] : groups_)
    for (const int32_t a : blocks_of(first, of_first))
      for (const int32_t b : blocks_of(second, of_second))
        if (a != kNoBlock && b != kNoBlock && a != b) out.emplace_back(std::min(a, b), std::max(a, b));
  groups_.clear();
}

}  // namespace stark
