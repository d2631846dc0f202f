// Reverse sweep with adjoints and second adjoints from given seeds down to given targets.
// Phase: kernel building.
#pragma once

#include <stark/symbolic/guards.h>
#include <stark/symbolic/partials.h>

#include <span>
#include <unordered_map>
#include <utility>
#include <vector>

namespace stark::symbolic {

/// Sweeps sum_k adjoint_k * seed_k, where adjoints count as constants, with respect to `targets`. A target is
/// a variable: what lies behind it is not looked at.
class EdgePushing {
 public:
  struct Seed {
    NodeId node, adjoint;
  };
  struct Entry {
    int column;  // place of a target, <= its row
    NodeId value;
  };

  EdgePushing(Graph& graph, std::span<const NodeId> targets, std::span<const Seed> seeds, bool second_order);

  /// By place in targets; -1 is zero.
  const std::vector<NodeId>& gradient() const { return gradient_; }
  /// Lower triangle by rows, entries in no particular order; absent entries are zero.
  const std::vector<std::vector<Entry>>& hessian() const { return hessian_; }
  /// Whether the target is used, but only inside arms of selects.
  bool is_conditional(int target) const {
    return target_guard_[target] != kAlways && target_guard_[target] != kNever;
  }

 private:
  struct Conditional {
    GuardId guard;
    NodeId sum;
  };
  void collect(std::span<const Seed> seeds);
  void find_guards(std::span<const Seed> seeds);
  void push(int i, bool second_order);
  void push_choice(int i, NodeId adjoint, bool second_order);
  void add_adjoint(int i, NodeId value, GuardId validity);
  void add_second(int i, int j, NodeId value, GuardId validity);
  NodeId resolve(uint64_t key, NodeId plain, GuardId known);
  int local(NodeId id) const { return local_[id]; }
  static uint64_t key(int i, int j) {
    return static_cast<uint64_t>(static_cast<uint32_t>(i)) << 32 | static_cast<uint32_t>(j);
  }

  Graph& graph_;
  Guards guards_;
  std::vector<int> local_;      // node -> local index, -1 if it does not depend on a target
  std::vector<NodeId> global_;  // local index -> node; targets first, then operands before users
  int target_count_;
  bool any_choice_ = false;
  std::vector<GuardId> guard_, target_guard_;
  std::vector<NodeId> adjoint_;
  std::vector<std::vector<Entry>> rows_;  // second adjoints, entry (i, j) with j <= i in row i
  std::unordered_map<uint64_t, std::vector<Conditional>> conditional_;
  std::vector<NodeId> gradient_;
  std::vector<std::vector<Entry>> hessian_;
};

}  // namespace stark::symbolic
