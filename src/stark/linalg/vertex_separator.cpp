// Multilevel vertex separators.
#include <stark/linalg/vertex_separator.h>

#include <algorithm>
#include <numeric>
#include <queue>
#include <span>

namespace stark {

namespace {

constexpr int32_t kCoarsestNodes = 100;
constexpr double kLeastShrink = 0.95;   // give up coarsening when a level keeps more than this
constexpr double kSideLimit = 0.6;      // of the total weight on one side
constexpr int kGrowingTries = 8;
constexpr int kRefinementPasses = 8;
constexpr int kFruitlessMoves = 120;    // hill climbing: moves without a better separator until a pass ends

// A fixed sequence of pseudo-random numbers.
class Sequence {
 public:
  uint32_t next() {
    state_ = state_ * 6364136223846793005ull + 1442695040888963407ull;
    return static_cast<uint32_t>(state_ >> 33);
  }

 private:
  uint64_t state_ = 0x853c49e6748fea9bull;
};

// Pairs of nodes joined by heavy edges; match[i] == i stays alone.
void match_heavy_edges(const WeightedGraph& graph, int32_t weight_limit, Sequence& random,
                       std::vector<int32_t>& match) {
  const int32_t n = graph.node_count();
  // Nodes with few neighbours choose first, in random order among equals, as they have the least choice.
  std::vector<int32_t> visit(n), order(n), bucket;
  std::iota(visit.begin(), visit.end(), 0);
  for (int32_t i = n - 1; i > 0; --i) std::swap(visit[i], visit[random.next() % static_cast<uint32_t>(i + 1)]);
  const int32_t classes = 64;
  const auto class_of = [&](int32_t i) { return std::min(graph.start[i + 1] - graph.start[i], classes - 1); };
  bucket.assign(classes + 1, 0);
  for (int32_t i : visit) ++bucket[class_of(i) + 1];
  for (int32_t c = 0; c < classes; ++c) bucket[c + 1] += bucket[c];
  for (int32_t i : visit) order[bucket[class_of(i)]++] = i;
  match.assign(n, -1);
  for (const int32_t i : order) {
    if (match[i] >= 0) continue;
    int32_t best = i, best_weight = 0;
    for (int32_t k = graph.start[i]; k < graph.start[i + 1]; ++k) {
      const int32_t j = graph.neighbor[k];
      if (match[j] >= 0 || graph.node_weight[i] + graph.node_weight[j] > weight_limit) continue;
      if (graph.edge_weight[k] > best_weight) best = j, best_weight = graph.edge_weight[k];
    }
    match[i] = best;
    match[best] = i;
  }
  // Nodes left alone, such as the leaves of a star, pair up with another one at the same neighbour.
  for (int32_t center = 0; center < n; ++center) {
    int32_t waiting = -1;
    for (int32_t k = graph.start[center]; k < graph.start[center + 1]; ++k) {
      const int32_t j = graph.neighbor[k];
      if (match[j] != j) continue;
      if (waiting < 0) {
        waiting = j;
      } else if (graph.node_weight[waiting] + graph.node_weight[j] <= weight_limit) {
        match[waiting] = j;
        match[j] = waiting;
        waiting = -1;
      }
    }
  }
}

void contract(const WeightedGraph& fine, const std::vector<int32_t>& match, WeightedGraph& coarse,
              std::vector<int32_t>& coarse_of) {
  const int32_t n = fine.node_count();
  coarse_of.assign(n, -1);
  int32_t count = 0;
  for (int32_t i = 0; i < n; ++i)
    if (match[i] >= i) coarse_of[i] = coarse_of[match[i]] = count++;
  coarse.start.assign(1, 0);
  coarse.start.reserve(static_cast<size_t>(count) + 1);
  coarse.neighbor.reserve(fine.neighbor.size());
  coarse.edge_weight.reserve(fine.neighbor.size());
  coarse.node_weight.reserve(count);
  std::vector<int32_t> place(count, -1);  // of a neighbour in the current list
  for (int32_t i = 0; i < n; ++i) {
    if (match[i] < i) continue;
    const int32_t self = coarse_of[i];
    const auto begin = static_cast<int32_t>(coarse.neighbor.size());
    const auto add_edges_of = [&](int32_t node) {
      for (int32_t k = fine.start[node]; k < fine.start[node + 1]; ++k) {
        const int32_t c = coarse_of[fine.neighbor[k]];
        if (c == self) continue;
        if (place[c] >= begin && coarse.neighbor[place[c]] == c) {
          coarse.edge_weight[place[c]] += fine.edge_weight[k];
        } else {
          place[c] = static_cast<int32_t>(coarse.neighbor.size());
          coarse.neighbor.push_back(c);
          coarse.edge_weight.push_back(fine.edge_weight[k]);
        }
      }
    };
    add_edges_of(i);
    if (match[i] != i) add_edges_of(match[i]);
    coarse.node_weight.push_back(fine.node_weight[i] + (match[i] != i ? fine.node_weight[match[i]] : 0));
    coarse.start.push_back(static_cast<int32_t>(coarse.neighbor.size()));
  }
}

// A separator of one graph and its improvement by moves of separator nodes to a side.
class Separator {
 public:
  Separator(const WeightedGraph& graph, std::vector<uint8_t>& part) : graph_(graph), part_(part) {
    total_ = std::accumulate(graph.node_weight.begin(), graph.node_weight.end(), int64_t{0});
    const int32_t n = graph.node_count();
    outside_[0].assign(n, 0);
    outside_[1].assign(n, 0);
    moved_.assign(n, 0);
  }

  void measure() {
    weight_[0] = weight_[1] = weight_[2] = 0;
    for (int32_t i = 0; i < graph_.node_count(); ++i) weight_[part_[i]] += graph_.node_weight[i];
  }
  /// Separator weight, with a surcharge for what a side has above the limit.
  double cost() const {
    const double heavier = static_cast<double>(std::max(weight_[0], weight_[1]));
    const double excess = std::max(0.0, heavier - kSideLimit * static_cast<double>(total_));
    return static_cast<double>(weight_[2]) + 2.0 * excess;
  }
  int64_t imbalance() const { return std::abs(weight_[0] - weight_[1]); }

  void grow_from(int32_t seed);
  void refine();

 private:
  struct Candidate {
    int32_t gain;
    int32_t node;
    bool operator<(const Candidate& other) const {
      return gain != other.gain ? gain < other.gain : node > other.node;
    }
  };
  using Queue = std::priority_queue<Candidate>;

  // Separator weight saved by moving node i to `side`: its own, less what it pulls in from the other side.
  int32_t gain(int32_t i, int side) const { return graph_.node_weight[i] - outside_[1 - side][i]; }
  void enter_separator(int32_t i);
  void move(int32_t i, int side);
  bool top(int side, Candidate& out);
  bool pass();

  const WeightedGraph& graph_;
  std::vector<uint8_t>& part_;
  int64_t total_ = 0;
  int64_t weight_[3] = {0, 0, 0};
  std::vector<int32_t> outside_[2];  // of a separator node: weight of its neighbours on a side
  std::vector<uint8_t> moved_;
  Queue queue_[2];
  std::vector<int32_t> log_;         // per move: nodes pulled in, their number, node, side
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
        if (part_[x] != kSeparator || x == j) continue;
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
  queue_[0] = Queue();
  queue_[1] = Queue();
  log_.clear();
  for (int32_t i = 0; i < graph_.node_count(); ++i)
    if (part_[i] == kSeparator) enter_separator(i);
  const double start_cost = cost();
  const int64_t start_imbalance = imbalance();
  double best_cost = start_cost;
  int64_t best_imbalance = start_imbalance;
  size_t best_log = 0;
  const auto limit = static_cast<int64_t>(kSideLimit * static_cast<double>(total_));
  for (int fruitless = 0; fruitless < kFruitlessMoves; ++fruitless) {
    Candidate candidate[2];
    bool possible[2];
    for (int side = 0; side < 2; ++side) {
      possible[side] = top(side, candidate[side]);
      // A side above the limit only gives.
      if (possible[side] && weight_[side] + graph_.node_weight[candidate[side].node] > limit &&
          weight_[side] >= weight_[1 - side])
        possible[side] = false;
    }
    if (!possible[0] && !possible[1]) break;
    const int lighter = weight_[1] < weight_[0] ? 1 : 0;
    int side = possible[lighter] ? lighter : 1 - lighter;
    if (possible[0] && possible[1] && candidate[1 - side].gain > candidate[side].gain) side = 1 - side;
    if (weight_[1 - lighter] > limit && possible[lighter]) side = lighter;
    move(candidate[side].node, side);
    const double now = cost();
    if (now < best_cost || (now == best_cost && imbalance() < best_imbalance)) {
      best_cost = now;
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
  measure();
  return best_cost < start_cost || best_imbalance < start_imbalance;
}

void Separator::refine() {
  measure();
  for (int k = 0; k < kRefinementPasses; ++k)
    if (!pass()) break;
}

// Side 0 grows from a seed, always by the separator node of the largest gain, until the sides are even.
void Separator::grow_from(int32_t seed) {
  std::fill(part_.begin(), part_.end(), uint8_t{1});
  std::fill(moved_.begin(), moved_.end(), uint8_t{0});
  queue_[0] = Queue();
  queue_[1] = Queue();
  log_.clear();
  measure();
  part_[seed] = kSeparator;
  weight_[1] -= graph_.node_weight[seed];
  weight_[kSeparator] += graph_.node_weight[seed];
  enter_separator(seed);
  while (weight_[0] < weight_[1]) {
    Candidate candidate;
    if (!top(0, candidate)) {  // the component is used up: go on in another one
      int32_t other = -1;
      for (int32_t i = 0; i < graph_.node_count() && other < 0; ++i)
        if (part_[i] == 1) other = i;
      if (other < 0) break;
      part_[other] = kSeparator;
      weight_[1] -= graph_.node_weight[other];
      weight_[kSeparator] += graph_.node_weight[other];
      enter_separator(other);
      continue;
    }
    move(candidate.node, 0);
  }
}

void separate_coarsest(const WeightedGraph& graph, Sequence& random, std::vector<uint8_t>& part) {
  const int32_t n = graph.node_count();
  std::vector<uint8_t> trial(n);
  double best_cost = 0.0;
  int64_t best_imbalance = 0;
  for (int k = 0; k < kGrowingTries; ++k) {
    Separator separator(graph, trial);
    separator.grow_from(static_cast<int32_t>(random.next() % static_cast<uint32_t>(n)));
    separator.refine();
    if (k == 0 || separator.cost() < best_cost ||
        (separator.cost() == best_cost && separator.imbalance() < best_imbalance)) {
      best_cost = separator.cost();
      best_imbalance = separator.imbalance();
      part = trial;
    }
  }
}

}  // namespace

void find_vertex_separator(const WeightedGraph& graph, std::vector<uint8_t>& out_part) {
  out_part.assign(graph.node_count(), 0);
  if (graph.node_count() < 2) return;
  Sequence random;
  std::vector<WeightedGraph> coarse;            // coarse[k] is one level above graph (k = 0) or coarse[k - 1]
  std::vector<std::vector<int32_t>> coarse_of;
  std::vector<int32_t> match;
  const int64_t total = std::accumulate(graph.node_weight.begin(), graph.node_weight.end(), int64_t{0});
  const auto weight_limit = static_cast<int32_t>(std::max<int64_t>(2, 3 * total / (2 * kCoarsestNodes)));
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
  std::vector<uint8_t> part;
  separate_coarsest(level(coarse.size()), random, part);
  for (size_t k = coarse.size(); k-- > 0;) {
    const WeightedGraph& fine = level(k);
    std::vector<uint8_t> fine_part(fine.node_count());
    for (int32_t i = 0; i < fine.node_count(); ++i) fine_part[i] = part[coarse_of[k][i]];
    Separator separator(fine, fine_part);
    separator.refine();
    part = std::move(fine_part);
  }
  out_part = std::move(part);
}

}  // namespace stark
