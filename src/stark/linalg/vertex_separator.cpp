// Multilevel vertex separators: edge bisections on the coarse levels, where a vertex separator of heavy nodes
// says little, and the vertex separator proper on the finest.
#include <stark/linalg/vertex_separator.h>

#include <algorithm>
#include <numeric>

#include <stark/linalg/graph_coarsening.h>

namespace stark {

namespace {

constexpr int32_t kCoarsestNodes = 80;
constexpr double kLeastShrink = 0.95;     // give up coarsening when a level keeps more than this
constexpr double kBisectionLimit = 0.55;  // of the total weight on one side of a bisection,
constexpr double kSideLimit = 0.6;        // and on one side of the separator
constexpr int kStarts = 4;
constexpr int32_t kDecisionNodes = 200;  // the level on which the best start is chosen
constexpr int kBisectionPasses = 4;
constexpr int kSeparatorPasses = 8;
constexpr int kFruitlessMoves = 60;  // hill climbing: moves without improvement until a pass ends

struct Candidate {
  int32_t gain;
  int32_t node;
  bool operator<(const Candidate& other) const {
    return gain != other.gain ? gain < other.gain : node > other.node;
  }
};
// A heap that keeps its storage when it is emptied.
class Queue {
 public:
  bool empty() const { return heap_.empty(); }
  const Candidate& top() const { return heap_.front(); }
  void push(Candidate candidate) {
    heap_.push_back(candidate);
    std::push_heap(heap_.begin(), heap_.end());
  }
  void pop() {
    std::pop_heap(heap_.begin(), heap_.end());
    heap_.pop_back();
  }
  void clear() { heap_.clear(); }
  // Fills without order; make() must follow.
  void add(Candidate candidate) { heap_.push_back(candidate); }
  void make() { std::make_heap(heap_.begin(), heap_.end()); }

 private:
  std::vector<Candidate> heap_;
};

int64_t total_weight(const WeightedGraph& graph) {
  return std::accumulate(graph.node_weight.begin(), graph.node_weight.end(), int64_t{0});
}

// Two sides and the weight of the edges between them, lowered by moves of border nodes to the other side.
class Bisection {
 public:
  Bisection(const WeightedGraph& graph, std::vector<uint8_t>& part)
      : graph_(graph),
        part_(part),
        outer_(graph.node_count()),
        total_(graph.node_count()),
        moved_(graph.node_count()) {
    limit_ = static_cast<int64_t>(kBisectionLimit * static_cast<double>(total_weight(graph)));
    measure();
  }

  /// Weight cut, with a surcharge for what a side has above the limit.
  int64_t cost() const { return cut_ + 4 * std::max<int64_t>(0, std::max(weight_[0], weight_[1]) - limit_); }
  void refine() {
    for (int k = 0; k < kBisectionPasses && pass(); ++k) {
    }
  }

 private:
  void measure();
  // Weight saved by a change of side.
  int32_t gain(int32_t i) const { return 2 * outer_[i] - total_[i]; }
  void move(int32_t i);
  bool top(int side, Candidate& out);
  bool pass();

  const WeightedGraph& graph_;
  std::vector<uint8_t>& part_;
  std::vector<int32_t> outer_, total_;  // weight of a node's edges to the other side, and of all its edges
  std::vector<uint8_t> moved_;
  int64_t weight_[2] = {0, 0}, cut_ = 0, limit_ = 0;
  Queue queue_[2];  // of the nodes now on a side
  std::vector<int32_t> log_;
};

void Bisection::measure() {
  for (int32_t i = 0; i < graph_.node_count(); ++i) {
    weight_[part_[i]] += graph_.node_weight[i];
    int32_t outer = 0, total = 0;
    for (int32_t k = graph_.start[i]; k < graph_.start[i + 1]; ++k) {
      total += graph_.edge_weight[k];
      outer += part_[graph_.neighbor[k]] != part_[i] ? graph_.edge_weight[k] : 0;
    }
    outer_[i] = outer;
    total_[i] = total;
    cut_ += outer;
  }
  cut_ /= 2;
}

void Bisection::move(int32_t i) {
  const int from = part_[i];
  weight_[from] -= graph_.node_weight[i];
  weight_[1 - from] += graph_.node_weight[i];
  cut_ -= gain(i);
  outer_[i] = total_[i] - outer_[i];
  part_[i] = static_cast<uint8_t>(1 - from);
  for (int32_t k = graph_.start[i]; k < graph_.start[i + 1]; ++k) {
    const int32_t j = graph_.neighbor[k];
    outer_[j] += part_[j] == from ? graph_.edge_weight[k] : -graph_.edge_weight[k];
    if (!moved_[j] && outer_[j] > 0) queue_[part_[j]].push({gain(j), j});
  }
}

bool Bisection::top(int side, Candidate& out) {
  Queue& queue = queue_[side];
  while (!queue.empty()) {
    out = queue.top();
    if (!moved_[out.node] && part_[out.node] == side && outer_[out.node] > 0 && gain(out.node) == out.gain)
      return true;
    queue.pop();
  }
  return false;
}

// One pass of moves, undone beyond the best bisection seen. True if that is an improvement.
bool Bisection::pass() {
  std::fill(moved_.begin(), moved_.end(), uint8_t{0});
  queue_[0].clear();
  queue_[1].clear();
  for (int32_t i = 0; i < graph_.node_count(); ++i)
    if (outer_[i] > 0) queue_[part_[i]].add({gain(i), i});
  queue_[0].make();
  queue_[1].make();
  log_.clear();
  const int64_t start_cost = cost();
  int64_t best_cost = start_cost;
  size_t best_log = 0;
  for (int fruitless = 0; fruitless < kFruitlessMoves; ++fruitless) {
    Candidate candidate[2];
    bool possible[2];
    for (int from = 0; from < 2; ++from) {
      possible[from] = top(from, candidate[from]);
      if (possible[from] && weight_[from] < weight_[1 - from] &&
          weight_[1 - from] + graph_.node_weight[candidate[from].node] > limit_)
        possible[from] = false;
    }
    const int heavier = weight_[1] > weight_[0] ? 1 : 0;
    if (!possible[0] && !possible[1]) break;
    int from = possible[heavier] ? heavier : 1 - heavier;
    if (weight_[heavier] <= limit_ && possible[1 - from] && candidate[1 - from].gain > candidate[from].gain)
      from = 1 - from;
    const int32_t node = candidate[from].node;
    moved_[node] = 1;
    move(node);
    log_.push_back(node);
    if (cost() < best_cost) {
      best_cost = cost();
      best_log = log_.size();
      fruitless = 0;
    }
  }
  for (; log_.size() > best_log; log_.pop_back()) move(log_.back());
  return best_cost < start_cost;
}

// A vertex separator, lightened by moves of separator nodes to a side, which pull in their neighbours on the
// other.
class Separator {
 public:
  Separator(const WeightedGraph& graph, std::vector<uint8_t>& part) : graph_(graph), part_(part) {
    limit_ = static_cast<int64_t>(kSideLimit * static_cast<double>(total_weight(graph)));
    outside_[0].assign(graph.node_count(), 0);
    outside_[1].assign(graph.node_count(), 0);
    moved_.assign(graph.node_count(), 0);
  }
  void refine() {
    for (int k = 0; k < kSeparatorPasses && pass(); ++k) {
    }
  }

 private:
  int64_t cost() const {
    return weight_[2] + 2 * std::max<int64_t>(0, std::max(weight_[0], weight_[1]) - limit_);
  }
  int64_t imbalance() const { return std::abs(weight_[0] - weight_[1]); }
  // Separator weight saved by moving node i to `side`: its own, less what it pulls in from the other side.
  int32_t gain(int32_t i, int side) const { return graph_.node_weight[i] - outside_[1 - side][i]; }
  void enter_separator(int32_t i);
  void move(int32_t i, int side);
  bool top(int side, Candidate& out);
  bool pass();

  const WeightedGraph& graph_;
  std::vector<uint8_t>& part_;
  int64_t weight_[3] = {0, 0, 0}, limit_ = 0;
  std::vector<int32_t> outside_[2];  // of a separator node: weight of its neighbours on a side
  std::vector<uint8_t> moved_;
  Queue queue_[2];
  std::vector<int32_t> log_;  // per move: nodes pulled in, their number, node, side
};

// Sums up the surroundings of a node that has just become part of the separator and queues it.
void Separator::enter_separator(int32_t i) {
  int32_t sum[3] = {0, 0, 0};
  for (int32_t k = graph_.start[i]; k < graph_.start[i + 1]; ++k) {
    const int32_t j = graph_.neighbor[k];
    sum[part_[j]] += graph_.node_weight[j];
  }
  outside_[0][i] = sum[0];
  outside_[1][i] = sum[1];
  if (moved_[i]) return;
  for (int side = 0; side < 2; ++side) queue_[side].push({gain(i, side), i});
}

void Separator::move(int32_t i, int side) {
  const int32_t weight = graph_.node_weight[i];
  part_[i] = static_cast<uint8_t>(side);
  moved_[i] = 1;
  weight_[side] += weight;
  weight_[kSeparator] -= weight;
  int32_t pulled = 0;
  for (int32_t k = graph_.start[i]; k < graph_.start[i + 1]; ++k) {
    const int32_t j = graph_.neighbor[k];
    if (part_[j] == kSeparator) {
      outside_[side][j] += weight;
      if (!moved_[j]) queue_[1 - side].push({gain(j, 1 - side), j});
    } else if (part_[j] == 1 - side) {
      part_[j] = kSeparator;
      const int32_t other = graph_.node_weight[j];
      weight_[1 - side] -= other;
      weight_[kSeparator] += other;
      for (int32_t m = graph_.start[j]; m < graph_.start[j + 1]; ++m) {
        const int32_t x = graph_.neighbor[m];
        if (part_[x] != kSeparator) continue;
        outside_[1 - side][x] -= other;
        if (!moved_[x]) queue_[side].push({gain(x, side), x});
      }
      enter_separator(j);
      log_.push_back(j);
      ++pulled;
    }
  }
  log_.push_back(pulled);
  log_.push_back(i);
  log_.push_back(side);
}

// Best valid candidate for a side; entries that no longer hold are dropped.
bool Separator::top(int side, Candidate& out) {
  Queue& queue = queue_[side];
  while (!queue.empty()) {
    out = queue.top();
    if (part_[out.node] == kSeparator && !moved_[out.node] && gain(out.node, side) == out.gain) return true;
    queue.pop();
  }
  return false;
}

// One pass of moves, undone beyond the best separator seen. True if that is an improvement.
bool Separator::pass() {
  std::fill(moved_.begin(), moved_.end(), uint8_t{0});
  queue_[0].clear();
  queue_[1].clear();
  log_.clear();
  weight_[0] = weight_[1] = weight_[2] = 0;
  for (int32_t i = 0; i < graph_.node_count(); ++i) {
    weight_[part_[i]] += graph_.node_weight[i];
    if (part_[i] == kSeparator) enter_separator(i);
  }
  const int64_t start_cost = cost(), start_imbalance = imbalance();
  int64_t best_cost = start_cost, best_imbalance = start_imbalance;
  size_t best_log = 0;
  for (int fruitless = 0; fruitless < kFruitlessMoves; ++fruitless) {
    Candidate candidate[2];
    bool possible[2];
    for (int side = 0; side < 2; ++side) {
      possible[side] = top(side, candidate[side]);
      // A side above the limit only gives.
      if (possible[side] && weight_[side] + graph_.node_weight[candidate[side].node] > limit_ &&
          weight_[side] >= weight_[1 - side])
        possible[side] = false;
    }
    if (!possible[0] && !possible[1]) break;
    const int lighter = weight_[1] < weight_[0] ? 1 : 0;
    int side = possible[lighter] ? lighter : 1 - lighter;
    if (weight_[1 - lighter] <= limit_ && possible[1 - side] &&
        candidate[1 - side].gain > candidate[side].gain)
      side = 1 - side;
    move(candidate[side].node, side);
    if (cost() < best_cost || (cost() == best_cost && imbalance() < best_imbalance)) {
      best_cost = cost();
      best_imbalance = imbalance();
      best_log = log_.size();
      fruitless = 0;
    }
  }
  while (log_.size() > best_log) {
    const int side = log_[log_.size() - 1];
    const int32_t node = log_[log_.size() - 2], pulled = log_[log_.size() - 3];
    log_.resize(log_.size() - 3);
    for (int32_t k = 0; k < pulled; ++k, log_.pop_back()) part_[log_.back()] = static_cast<uint8_t>(1 - side);
    part_[node] = kSeparator;
  }
  return best_cost < start_cost || best_imbalance < start_imbalance;
}

// Side 0 grows from a seed, always by the node with the most edges into it and the fewest out, until the
// sides are even.
void grow_side(const WeightedGraph& graph, int32_t seed, std::vector<uint8_t>& part) {
  const int32_t n = graph.node_count();
  const int64_t total = total_weight(graph);
  part.assign(n, 1);
  std::vector<int32_t> gain(n, 0);
  for (int32_t i = 0; i < n; ++i)
    for (int32_t k = graph.start[i]; k < graph.start[i + 1]; ++k) gain[i] -= graph.edge_weight[k];
  Queue queue;
  queue.push({gain[seed], seed});
  int32_t unseen = 0;
  for (int64_t grown = 0; 2 * grown < total;) {
    if (queue.empty()) {  // the component is used up: go on in another one
      while (unseen < n && part[unseen] == 0) ++unseen;
      if (unseen == n) break;
      queue.push({gain[unseen], unseen});
    }
    const Candidate best = queue.top();
    queue.pop();
    const int32_t i = best.node;
    if (part[i] == 0 || gain[i] != best.gain) continue;
    part[i] = 0;
    grown += graph.node_weight[i];
    for (int32_t k = graph.start[i]; k < graph.start[i + 1]; ++k) {
      const int32_t j = graph.neighbor[k];
      if (part[j] == 0) continue;
      gain[j] += 2 * graph.edge_weight[k];
      queue.push({gain[j], j});
    }
  }
}

// The lighter of the two borders of a bisection becomes the separator.
void separate_border(const WeightedGraph& graph, std::vector<uint8_t>& part) {
  int64_t weight[2] = {0, 0};
  std::vector<int32_t> border[2];
  for (int32_t i = 0; i < graph.node_count(); ++i)
    for (int32_t k = graph.start[i]; k < graph.start[i + 1]; ++k)
      if (part[graph.neighbor[k]] != part[i]) {
        border[part[i]].push_back(i);
        weight[part[i]] += graph.node_weight[i];
        break;
      }
  for (const int32_t i : border[weight[1] < weight[0] ? 1 : 0]) part[i] = kSeparator;
}

}  // namespace

void find_vertex_separator(const WeightedGraph& graph, std::vector<uint8_t>& out_part) {
  out_part.assign(graph.node_count(), 0);
  if (graph.node_count() < 2) return;
  PseudoRandom random;
  std::vector<WeightedGraph> coarse;  // coarse[k] is one level above graph (k = 0) or coarse[k - 1]
  std::vector<std::vector<int32_t>> coarse_of;
  std::vector<int32_t> match;
  const auto weight_limit =
      static_cast<int32_t>(std::max<int64_t>(2, 3 * total_weight(graph) / (2 * kCoarsestNodes)));
  const auto level = [&](size_t k) -> const WeightedGraph& { return k == 0 ? graph : coarse[k - 1]; };
  while (level(coarse.size()).node_count() > kCoarsestNodes) {
    const WeightedGraph& fine = level(coarse.size());
    match_heavy_edges(fine, weight_limit, random, match);
    WeightedGraph next;
    std::vector<int32_t> map;
    contract(fine, match, next, map);
    if (next.node_count() > kLeastShrink * fine.node_count()) break;
    coarse.push_back(std::move(next));
    coarse_of.push_back(std::move(map));
  }
  // Carries a bisection of level `from` down to level `to`, improving it on the way; returns its cost.
  const auto refine_down = [&](std::vector<uint8_t>& part, size_t from, size_t to) {
    for (size_t k = from;; --k) {
      Bisection bisection(level(k), part);
      bisection.refine();
      if (k == to) return bisection.cost();
      std::vector<uint8_t> fine_part(level(k - 1).node_count());
      for (size_t i = 0; i < fine_part.size(); ++i) fine_part[i] = part[coarse_of[k - 1][i]];
      part = std::move(fine_part);
    }
  };
  // Several starts compete up to a level of moderate size.
  size_t decision = coarse.size();
  while (decision > 0 && level(decision - 1).node_count() <= kDecisionNodes) --decision;
  const WeightedGraph& coarsest = level(coarse.size());
  std::vector<uint8_t> trial;
  int64_t best_cost = 0;
  for (int k = 0; k < kStarts; ++k) {
    grow_side(coarsest, random.below(coarsest.node_count()), trial);
    const int64_t cost = refine_down(trial, coarse.size(), decision);
    if (k > 0 && cost >= best_cost) continue;
    best_cost = cost;
    out_part = trial;
  }
  refine_down(out_part, decision, 0);
  separate_border(graph, out_part);
  Separator(graph, out_part).refine();
}

}  // namespace stark
