// Kernels: differentiation, lowering and code, built once per order and shared by content.
// Phase: model building; evaluate() in every assembly.
#include <stark/symbolic/kernel.h>

#include <stark/base/error.h>
#include <stark/base/hash.h>
#include <stark/symbolic/backend/executable.h>
#include <stark/symbolic/diff.h>
#include <stark/symbolic/lower.h>

#include <bit>
#include <chrono>
#include <map>
#include <mutex>
#include <utility>
#include <vector>

namespace stark::symbolic {

struct KernelState {
  Graph graph;  // private copy: the user's graph may go away
  NodeId energy = -1;
  std::vector<NodeId> stages;
  Backend backend = Backend::Interpreter;
  uint64_t fingerprint = 0;  // of what follows the back end in the content key
  int count[3] = {0, 0, 0};  // inputs by kind

  std::mutex mutex;  // of the graph and of the statistics while building
  std::once_flag built[3];
  std::unique_ptr<Executable> code[3];
  KernelStatistics statistics;

  void build(int order);
  const Executable& get(int order) {
    std::call_once(built[order], [&] { build(order); });
    return *code[order];
  }
};

void KernelState::build(int order) {
  const std::lock_guard lock(mutex);
  const auto begin = std::chrono::steady_clock::now();
  std::vector<std::vector<NodeId>> groups{{energy}};
  if (order == 1) {
    groups.push_back(gradient(graph, energy).gradient);
  } else if (order == 2) {
    Derivatives d = cheapest_hessian(graph, energy, stages);
    statistics.algorithm = to_string(d.algorithm);
    groups.push_back(std::move(d.gradient));
    groups.back().insert(groups.back().end(), d.hessian.begin(), d.hessian.end());
  }
  std::vector<NodeId> outputs;
  for (const auto& g : groups) outputs.insert(outputs.end(), g.begin(), g.end());
  const Program program = lower(graph, groups);
  code[order] = make_executable(program, backend, statistics.backend);
  statistics.operations[order] = operation_total(graph, outputs);
  statistics.instructions[order] = static_cast<int>(program.instructions.size());
  statistics.spill_slots[order] = code[order]->spill_slots;
  statistics.code_bytes[order] = code[order]->code_bytes;
  statistics.build_seconds[order] =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

namespace {

// Complete description of a kernel: equal keys are equal kernels.
std::vector<uint64_t> content_key(const KernelState& state) {
  std::vector<uint64_t> key{static_cast<uint64_t>(state.backend), static_cast<uint64_t>(state.energy)};
  for (const int c : state.count) key.push_back(static_cast<uint64_t>(c));
  for (const NodeId s : state.stages) key.push_back(static_cast<uint64_t>(s) << 8 | 0xff);
  for (NodeId id = 0; id < state.graph.size(); ++id) {
    const Node& n = state.graph.node(id);
    key.push_back(static_cast<uint64_t>(n.op) | static_cast<uint64_t>(static_cast<uint32_t>(n.operands[0]))
                                                    << 8);
    key.push_back(static_cast<uint64_t>(static_cast<uint32_t>(n.operands[1])) << 32 |
                  static_cast<uint32_t>(n.operands[2]));
    key.push_back(std::bit_cast<uint64_t>(n.value));
  }
  return key;
}

// Kernels that are alive, by content. A cache only: a miss costs a build and changes no result.
class KernelCache {
 public:
  std::shared_ptr<KernelState> find_or_insert(std::vector<uint64_t> key, std::shared_ptr<KernelState> state) {
    const std::lock_guard lock(mutex_);
    auto& entry = entries_[std::move(key)];
    if (auto existing = entry.lock()) return existing;
    entry = state;
    std::erase_if(entries_, [](const auto& e) { return e.second.expired(); });
    return state;
  }

 private:
  std::mutex mutex_;
  std::map<std::vector<uint64_t>, std::weak_ptr<KernelState>> entries_;
};

KernelCache& kernel_cache() {
  static KernelCache cache;
  return cache;
}

}  // namespace

Kernel compile(const Scalar& energy, Backend backend) {
  if (energy.is_condition()) {
    throw InvalidArgument("compile: the energy is a condition, not a number; use select(condition, a, b).");
  }
  auto state = std::make_shared<KernelState>();
  state->backend = resolve_backend(backend);
  if (energy.is_literal()) {
    state->energy = state->graph.constant(energy.value());
  } else {
    const Graph& source = *energy.graph();
    // Stages that the energy does not use are dropped by differentiation.
    std::vector<NodeId> roots{energy.id()};
    const auto& marked = source.stages();
    roots.insert(roots.end(), marked.begin(), marked.end());
    const std::vector<NodeId> images = import_expressions(source, roots, state->graph);
    state->energy = images[0];
    for (size_t k = 1; k < images.size(); ++k) {
      if (operand_count(state->graph.node(images[k]).op) > 0) state->stages.push_back(images[k]);
    }
  }
  for (int k = 0; k < 3; ++k) state->count[k] = state->graph.input_count(static_cast<InputKind>(k));
  state->statistics.backend = state->backend;
  std::vector<uint64_t> key = content_key(*state);
  Hash64 hash;
  hash.append_bytes(key.data() + 1, (key.size() - 1) * sizeof(uint64_t));
  state->fingerprint = hash.value();
  Kernel kernel;
  kernel.state_ = kernel_cache().find_or_insert(std::move(key), state);
  return kernel;
}

int Kernel::unknown_count() const { return state_->count[0]; }
int Kernel::element_count() const { return state_->count[1]; }
int Kernel::uniform_count() const { return state_->count[2]; }

int Kernel::output_count(Order order) const {
  const int n = state_->count[0];
  return order == Order::Energy ? 1 : (order == Order::Gradient ? 1 + n : 1 + n + n * (n + 1) / 2);
}

void Kernel::evaluate(Order order, const double* unknowns, const double* elements, const double* uniforms,
                      double* out_values, int64_t block_count) const {
  state_->get(static_cast<int>(order)).run(unknowns, elements, uniforms, out_values, block_count);
}

void Kernel::prepare(Order order) const { state_->get(static_cast<int>(order)); }

uint64_t Kernel::fingerprint() const { return state_->fingerprint; }

Backend Kernel::backend() const {
  prepare(Order::Energy);
  const std::lock_guard lock(state_->mutex);
  return state_->statistics.backend;
}

const KernelStatistics& Kernel::statistics() const {
  for (int order = 0; order < 3; ++order) state_->get(order);
  return state_->statistics;
}

}  // namespace stark::symbolic
