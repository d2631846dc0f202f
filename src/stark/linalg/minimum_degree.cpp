// Approximate minimum degree on a quotient graph: eliminated nodes live on as elements (cliques),
// indistinguishable variables are merged, and a variable's degree is bounded from above by the sizes of its
// elements outside the latest one (Amestoy, Davis and Duff 1996, section 4).
#include <algorithm>

#include <stark/linalg/ordering.h>

namespace stark {

namespace {

class QuotientGraph {
 public:
  QuotientGraph(const AdjacencyGraph& graph, std::span<const uint8_t> halo);
  void eliminate_all(std::vector<int32_t>& out_order);

 private:
  bool is_halo(int32_t i) const { return !halo_.empty() && halo_[i] != 0; }
  void insert(int32_t i, int32_t degree);
  void remove(int32_t i);
  int32_t next_pivot();
  void eliminate(int32_t pivot);
  void form_element(int32_t pivot);
  void measure_elements();
  void update_variable(int32_t i, int32_t pivot);
  void merge_indistinguishable();
  void finish_variables(int32_t pivot);
  void absorb(int32_t i, int32_t into) {
    absorbed_next_[absorbed_last_[into]] = i, absorbed_last_[into] = absorbed_last_[i];
  }

  int32_t n_;
  std::span<const uint8_t> halo_;
  // Lists of node i: list_[begin_[i]] ..: first element_count_[i] elements, up to count_[i] entries, then
  // variables. An element's list is of variables only.
  std::vector<int32_t> list_, begin_, count_, element_count_;
  std::vector<int32_t>
      weight_;  // columns a variable stands for, 0 once it is gone, negated while in the new element
  std::vector<int32_t> degree_;  // bound of a variable, weight of an element's variables
  std::vector<int64_t> mark_;    // of an element: stamp_ + weight outside the new element; 0: absorbed
  int64_t stamp_ = 1;
  std::vector<int32_t> bucket_, previous_, next_;  // variables by degree
  int32_t smallest_ = 0;
  int32_t remaining_ = 0;                               // columns not yet eliminated, halo included
  int32_t to_eliminate_ = 0;                            // without the halo
  std::vector<int32_t> absorbed_next_, absorbed_last_;  // variables eliminated together, chained
  std::vector<int32_t> members_;                        // variables of the new element
  int32_t element_weight_ = 0;
  int32_t pivot_weight_ = 0;
  std::vector<int32_t> scratch_, hash_bucket_, hash_next_, touched_;
  std::vector<int32_t> seen_;  // stamps for comparing lists
  int32_t seen_stamp_ = 0;
};

QuotientGraph::QuotientGraph(const AdjacencyGraph& graph, std::span<const uint8_t> halo)
    : n_(graph.node_count()), halo_(halo) {
  list_.reserve(2 * graph.neighbor.size() + static_cast<size_t>(n_));
  list_ = graph.neighbor;
  begin_.assign(graph.start.begin(), graph.start.end() - 1);
  count_.resize(n_);
  element_count_.assign(n_, 0);
  weight_.assign(n_, 1);
  degree_.resize(n_);
  mark_.assign(n_, 0);
  bucket_.assign(static_cast<size_t>(n_) + 1, -1);
  previous_.assign(n_, -1);
  next_.assign(n_, -1);
  absorbed_next_.assign(n_, -1);
  absorbed_last_.resize(n_);
  hash_bucket_.assign(n_, -1);
  hash_next_.assign(n_, -1);
  seen_.assign(n_, 0);
  remaining_ = n_;
  smallest_ = n_;
  for (int32_t i = n_ - 1; i >= 0;
       --i) {  // backwards, so that of equal degrees the smaller number goes first
    absorbed_last_[i] = i;
    count_[i] = degree_[i] = graph.degree(i);
    if (is_halo(i)) continue;
    ++to_eliminate_;
    insert(i, degree_[i]);
  }
}

void QuotientGraph::insert(int32_t i, int32_t degree) {
  degree_[i] = degree;
  previous_[i] = -1;
  next_[i] = bucket_[degree];
  if (next_[i] >= 0) previous_[next_[i]] = i;
  bucket_[degree] = i;
  smallest_ = std::min(smallest_, degree);
}

void QuotientGraph::remove(int32_t i) {
  if (next_[i] >= 0) previous_[next_[i]] = previous_[i];
  if (previous_[i] >= 0) {
    next_[previous_[i]] = next_[i];
  } else {
    bucket_[degree_[i]] = next_[i];
  }
}

int32_t QuotientGraph::next_pivot() {
  while (bucket_[smallest_] < 0) ++smallest_;
  return bucket_[smallest_];
}

// The new element: all variables adjacent to the pivot, directly or through elements, which it absorbs.
void QuotientGraph::form_element(int32_t pivot) {
  members_.clear();
  element_weight_ = 0;
  pivot_weight_ = weight_[pivot];
  weight_[pivot] = -pivot_weight_;
  const auto take = [&](int32_t i) {
    if (weight_[i] <= 0) return;
    element_weight_ += weight_[i];
    weight_[i] = -weight_[i];
    members_.push_back(i);
    if (!is_halo(i)) remove(i);
  };
  const int32_t begin = begin_[pivot];
  for (int32_t k = 0; k < count_[pivot]; ++k) {
    const int32_t item = list_[begin + k];
    if (k >= element_count_[pivot]) {
      take(item);
      continue;
    }
    for (int32_t m = 0; m < count_[item]; ++m) take(list_[begin_[item] + m]);
    mark_[item] = 0;
  }
}

// mark_[e] - stamp_ becomes the weight of the variables of element e outside the new one.
void QuotientGraph::measure_elements() {
  stamp_ += n_ + 1;
  for (const int32_t i : members_) {
    const int32_t weight = -weight_[i];
    for (int32_t k = 0; k < element_count_[i]; ++k) {
      const int32_t e = list_[begin_[i] + k];
      if (mark_[e] == 0) continue;
      if (mark_[e] < stamp_) mark_[e] = stamp_ + degree_[e];
      mark_[e] -= weight;
    }
  }
}

// Prunes the lists of member i, adds the new element, bounds the degree, hashes the lists.
void QuotientGraph::update_variable(int32_t i, int32_t pivot) {
  const int32_t begin = begin_[i];
  int32_t bound = 0;
  uint32_t hash = static_cast<uint32_t>(pivot);
  scratch_.clear();
  scratch_.push_back(pivot);
  for (int32_t k = 0; k < element_count_[i]; ++k) {
    const int32_t e = list_[begin + k];
    if (mark_[e] == 0) continue;
    const auto outside = static_cast<int32_t>(mark_[e] - stamp_);
    if (outside == 0) {  // a subset of the new element
      mark_[e] = 0;
      continue;
    }
    bound += outside;
    hash += static_cast<uint32_t>(e);
    scratch_.push_back(e);
  }
  const auto elements = static_cast<int32_t>(scratch_.size());
  for (int32_t k = element_count_[i]; k < count_[i]; ++k) {
    const int32_t j = list_[begin + k];
    if (weight_[j] <= 0) continue;  // gone, or in the new element, which covers the edge
    bound += weight_[j];
    hash += static_cast<uint32_t>(j);
    scratch_.push_back(j);
  }
  if (scratch_.size() == 1 && !is_halo(i)) {  // adjacent to nothing else: can go right after the pivot
    const int32_t weight = -weight_[i];
    pivot_weight_ += weight;
    element_weight_ -= weight;
    weight_[i] = 0;
    absorb(i, pivot);
    return;
  }
  std::copy(scratch_.begin(), scratch_.end(), list_.begin() + begin);
  element_count_[i] = elements;
  count_[i] = static_cast<int32_t>(scratch_.size());
  if (is_halo(i)) return;
  degree_[i] = std::min(degree_[i], bound);  // the weight of the new element is added at the end
  const auto bucket = static_cast<int32_t>(hash % static_cast<uint32_t>(n_));
  if (hash_bucket_[bucket] < 0) touched_.push_back(bucket);
  hash_next_[i] = hash_bucket_[bucket];
  hash_bucket_[bucket] = i;
}

void QuotientGraph::merge_indistinguishable() {
  for (const int32_t bucket : touched_) {
    for (int32_t i = hash_bucket_[bucket]; i >= 0; i = hash_next_[i]) {
      if (weight_[i] == 0 || hash_next_[i] < 0) continue;
      ++seen_stamp_;
      for (int32_t k = 0; k < count_[i]; ++k) seen_[list_[begin_[i] + k]] = seen_stamp_;
      for (int32_t j = hash_next_[i]; j >= 0; j = hash_next_[j]) {
        if (weight_[j] == 0 || count_[j] != count_[i] || element_count_[j] != element_count_[i]) continue;
        bool same = true;
        for (int32_t k = 0; k < count_[j] && same; ++k) same = seen_[list_[begin_[j] + k]] == seen_stamp_;
        if (!same) continue;
        weight_[i] += weight_[j];
        weight_[j] = 0;
        absorb(j, i);
      }
    }
    hash_bucket_[bucket] = -1;
  }
  touched_.clear();
}

void QuotientGraph::finish_variables(int32_t pivot) {
  begin_[pivot] = static_cast<int32_t>(list_.size());
  for (const int32_t i : members_) {
    if (weight_[i] == 0) continue;
    const int32_t weight = weight_[i] = -weight_[i];
    list_.push_back(i);
    if (is_halo(i)) continue;
    const int32_t bound = std::min(degree_[i] + element_weight_ - weight, remaining_ - weight);
    insert(i, std::max(bound, 0));
  }
  count_[pivot] = static_cast<int32_t>(list_.size()) - begin_[pivot];
  degree_[pivot] = element_weight_;
  mark_[pivot] = count_[pivot] > 0 ? 1 : 0;
}

void QuotientGraph::eliminate(int32_t pivot) {
  remove(pivot);
  form_element(pivot);
  measure_elements();
  for (const int32_t i : members_) update_variable(i, pivot);
  merge_indistinguishable();
  weight_[pivot] = 0;
  remaining_ -= pivot_weight_;
  to_eliminate_ -= pivot_weight_;
  finish_variables(pivot);
}

void QuotientGraph::eliminate_all(std::vector<int32_t>& out_order) {
  while (to_eliminate_ > 0) {
    const int32_t pivot = next_pivot();
    eliminate(pivot);
    for (int32_t i = pivot; i >= 0; i = absorbed_next_[i]) out_order.push_back(i);
  }
}

}  // namespace

void minimum_degree_order(const AdjacencyGraph& graph, std::span<const uint8_t> halo,
                          std::vector<int32_t>& out_order) {
  if (graph.node_count() == 0) return;
  QuotientGraph(graph, halo).eliminate_all(out_order);
}

}  // namespace stark
