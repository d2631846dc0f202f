// Functions of arrays. Inputs that the outputs use are numbered anew, so that unused entries of an argument
// cost nothing; batches are packed into the lane-major blocks of the back ends, a few blocks at a time.
// Phase: post-processing.
#include <stark/symbolic/array_function.h>

#include <stark/base/aligned.h>
#include <stark/base/error.h>
#include <stark/symbolic/diff.h>
#include <stark/symbolic/lower.h>
#include <stark/symbolic/partial_derivatives.h>

#include <algorithm>
#include <array>
#include <mutex>
#include <utility>

namespace stark::symbolic {

namespace {

/// Where an input of the code comes from.
struct Source {
  int argument, scalar;
};

}  // namespace

struct ArrayFunctionState {
  Graph graph;                             // Unknowns: used variables; Elements: other used scalars
  std::vector<Scalar> outputs;             // m, of this graph or numbers
  std::vector<Source> unknowns, elements;  // by number of the input
  std::vector<int> variable;               // by number of an unknown: its place among all n variables
  std::vector<char> used;                  // by argument
  int variable_count = 0;
  Backend requested = Backend::Automatic;
  Backend backend = Backend::Interpreter;

  Kernel kernel;  // if m = 1
  std::mutex mutex;
  std::once_flag built[2];
  Function function[2];                   // if m > 1: values; values and first derivatives
  std::vector<std::array<int, 2>> first;  // (output, variable) of the first derivatives that are not zero

  void import(std::span<const Scalar> given, std::span<const ArrayArgument> arguments);
  void add_input(std::vector<NodeId>& image, const Graph& source, NodeId id, Source place,
                 int variable_place);
  void build(int order);
  const Function& get(int order) {
    std::call_once(built[order], [&] { build(order); });
    return function[order];
  }
};

namespace {

/// Blocks that are evaluated together: enough work for a call, few enough for inputs and outputs to stay in
/// the first-level cache, where results are read once per element.
int64_t blocks_together(size_t values_per_element) {
  constexpr int64_t kMost = 8, kCacheValues = 3072;  // 24 KiB
  return std::clamp<int64_t>(kCacheValues / static_cast<int64_t>(kLanes * (values_per_element + 1)), 1,
                             kMost);
}

Graph* graph_of(std::span<const Scalar> outputs) {
  Graph* graph = nullptr;
  for (const Scalar& y : outputs) {
    if (y.is_condition())
      throw TraceError("the result is a condition, not a number; return stark.where(condition, a, b)");
    if (y.is_literal()) continue;
    if (graph && y.graph() != graph) throw TraceError("the results belong to different formulas");
    graph = y.graph();
  }
  return graph;
}

void require_known_inputs(Graph& graph, const std::vector<char>& needed, const std::vector<NodeId>& image) {
  for (NodeId id = 0; id < static_cast<NodeId>(needed.size()); ++id) {
    const Op op = graph.node(id).op;
    if (!needed[id] || image[id] >= 0 || op == Op::Constant || operand_count(op) > 0) continue;
    throw TraceError("the result uses the symbol " + to_string(Scalar(&graph, id)) +
                     ", which is in no argument; add it to the inputs");
  }
}

}  // namespace

void ArrayFunctionState::add_input(std::vector<NodeId>& image, const Graph& source, NodeId id, Source place,
                                   int variable_place) {
  const bool unknown = variable_place >= 0;
  const Scalar input = graph.input(unknown ? InputKind::Unknown : InputKind::Element);
  if (const std::string name = source.name(id); !name.empty()) graph.set_name(input, name);
  image[id] = input.id();
  (unknown ? unknowns : elements).push_back(place);
  if (unknown) variable.push_back(variable_place);
  used[place.argument] = 1;
}

void ArrayFunctionState::import(std::span<const Scalar> given, std::span<const ArrayArgument> arguments) {
  Graph* source = graph_of(given);
  used.assign(arguments.size(), 0);
  std::vector<NodeId> roots;
  for (const Scalar& y : given) {
    if (!y.is_literal()) roots.push_back(y.id());
  }
  std::vector<char> needed;
  std::vector<NodeId> image;
  if (source) {
    needed = reachable(*source, roots);
    image.assign(source->size(), -1);
  }
  for (int a = 0; a < static_cast<int>(arguments.size()); ++a) {
    const ArrayArgument& argument = arguments[a];
    for (int k = 0; k < static_cast<int>(argument.inputs.size()); ++k) {
      const Scalar& x = argument.inputs[k];
      if (x.is_literal() || operand_count(x.graph()->node(x.id()).op) > 0 || x.is_constant())
        throw TraceError("argument '" + argument.name + "': " + to_string(x, 60) +
                         " is not a symbol; arguments are made of new symbols only");
      const int place = argument.differentiated ? variable_count++ : -1;
      if (x.graph() != source || x.id() >= static_cast<NodeId>(needed.size()) || !needed[x.id()]) continue;
      if (image[x.id()] >= 0)
        throw TraceError("argument '" + argument.name + "': the symbol " + to_string(x) +
                         " is in the arguments twice");
      add_input(image, *source, x.id(), {a, k}, place);
    }
  }
  std::vector<NodeId> imported;
  if (source) {
    require_known_inputs(*source, needed, image);
    for (const NodeId s : source->stages()) {
      if (s < static_cast<NodeId>(needed.size()) && needed[s]) roots.push_back(s);
    }
    imported = import_expressions(*source, roots, graph, std::move(image));
  }
  size_t next = 0;
  for (const Scalar& y : given) outputs.push_back(y.is_literal() ? y : Scalar(&graph, imported[next++]));
  for (; next < imported.size(); ++next) graph.mark_stage(Scalar(&graph, imported[next]));
}

void ArrayFunctionState::build(int order) {
  const std::lock_guard lock(mutex);
  std::vector<std::vector<Scalar>> groups{outputs};
  std::vector<std::array<int, 2>> places;  // kept when all has worked: a build that fails is tried again
  if (order == 1) {
    std::vector<NodeId> nodes;
    for (const Scalar& y : outputs) nodes.push_back(y.is_literal() ? graph.constant(y.value()) : y.id());
    const std::vector<NodeId> inputs = unknowns_of(graph);
    const std::vector<NodeId> entries = jacobian(graph, nodes, inputs);
    groups.emplace_back();
    for (size_t i = 0; i < nodes.size(); ++i) {
      for (size_t j = 0; j < inputs.size(); ++j) {
        const Scalar entry(&graph, entries[i * inputs.size() + j]);
        if (entry.is_constant() && entry.value() == 0.0) continue;
        groups.back().push_back(entry);
        places.push_back({static_cast<int>(i), variable[j]});
      }
    }
  }
  function[order] = compile_function(groups, requested);
  if (order == 1) first = std::move(places);
}

namespace {

/// Walks the elements of a batch in row-major order, with the place of each in one array.
class Walker {
 public:
  Walker(const StridedArray& array, std::span<const int64_t> shape)
      : array_(array), shape_(shape), index_(shape.size(), 0) {}

  /// Places of the next 8 elements; the last element again when there are no more.
  void next(int64_t count, int64_t (&places)[kLanes]) {
    for (int64_t lane = 0; lane < kLanes; ++lane) {
      places[lane] = place_;
      if (lane + 1 < count || count > kLanes) step();
    }
  }

 private:
  void step() {
    for (size_t d = shape_.size(); d-- > 0;) {
      place_ += array_.strides[d];
      if (++index_[d] < shape_[d]) return;
      place_ -= array_.strides[d] * shape_[d];
      index_[d] = 0;
    }
  }

  const StridedArray& array_;
  std::span<const int64_t> shape_;
  std::vector<int64_t> index_;
  int64_t place_ = 0;
};

/// Inputs of one kind, packed lane by lane.
class Packer {
 public:
  Packer(const std::vector<Source>& sources, std::span<const StridedArray> arrays, int64_t blocks)
      : sources_(sources), arrays_(arrays), lanes_(sources.size() * static_cast<size_t>(blocks * kLanes)) {}

  void pack(int64_t block, const std::vector<std::array<int64_t, kLanes>>& places) {
    double* out = lanes_.data() + block * static_cast<int64_t>(sources_.size()) * kLanes;
    for (const Source& s : sources_) {
      const double* data = arrays_[s.argument].data + arrays_[s.argument].offsets[s.scalar];
      for (const int64_t place : places[s.argument]) *out++ = data[place];
    }
  }
  const double* data() const { return lanes_.data(); }

 private:
  const std::vector<Source>& sources_;
  std::span<const StridedArray> arrays_;
  AlignedVector<double> lanes_;
};

}  // namespace

ArrayFunction::ArrayFunction(std::span<const Scalar> outputs, std::span<const ArrayArgument> arguments,
                             Backend backend)
    : state_(std::make_shared<ArrayFunctionState>()) {
  ArrayFunctionState& s = *state_;
  s.requested = backend;
  s.import(outputs, arguments);
  if (s.outputs.size() == 1) {
    s.kernel = compile(s.outputs[0], backend);
    s.backend = s.kernel.backend();
  } else {
    s.backend = s.get(0).backend();
  }
}

int ArrayFunction::output_count() const { return static_cast<int>(state_->outputs.size()); }
int ArrayFunction::variable_count() const { return state_->variable_count; }
bool ArrayFunction::uses(int argument) const { return state_->used[argument] != 0; }
Backend ArrayFunction::backend() const { return state_->backend; }

namespace {

/// Copies results of the code, which are lane-major, to where they belong. Entries that are identically zero
/// keep the zeros that the results start with.
class Scatter {
 public:
  Scatter(ArrayFunctionState& state, Order order, const ArrayResults& results)
      : state_(state), order_(order), results_(results), m_(state.outputs.size()), n_(state.variable_count) {}

  void copy(const double* values, int lane, int64_t element) const {
    const auto value = [&](size_t k) { return values[k * kLanes + lane]; };
    if (results_.values) {
      for (size_t i = 0; i < m_; ++i) results_.values[element * m_ + i] = value(i);
    }
    if (order_ == Order::Energy) return;
    if (results_.first) {
      double* out = results_.first + element * m_ * n_;
      if (m_ == 1) {
        for (size_t j = 0; j < state_.variable.size(); ++j) out[state_.variable[j]] = value(1 + j);
      } else {
        for (size_t k = 0; k < state_.first.size(); ++k)
          out[state_.first[k][0] * n_ + state_.first[k][1]] = value(m_ + k);
      }
    }
    if (order_ == Order::Hessian && results_.second) copy_second(values, lane, element);
  }

 private:
  void copy_second(const double* values, int lane, int64_t element) const {
    const std::vector<int>& place = state_.variable;
    double* out = results_.second + element * n_ * n_;
    const double* next = values + (1 + place.size()) * kLanes + lane;
    for (size_t i = 0; i < place.size(); ++i) {
      for (size_t j = i; j < place.size(); ++j, next += kLanes)
        out[place[i] * n_ + place[j]] = out[place[j] * n_ + place[i]] = *next;
    }
  }

  ArrayFunctionState& state_;
  Order order_;
  const ArrayResults& results_;
  size_t m_, n_;
};

}  // namespace

void ArrayFunction::evaluate(Order order, std::span<const StridedArray> arguments,
                             std::span<const int64_t> shape, const ArrayResults& out_results) const {
  ArrayFunctionState& s = *state_;
  const bool energy = s.outputs.size() == 1;
  if (order == Order::Hessian && !energy)
    throw InvalidArgument("second derivatives: the function has " + std::to_string(s.outputs.size()) +
                          " outputs: must be 1; use its jacobian");
  if (arguments.size() != s.used.size())
    throw InvalidArgument("evaluate: got " + std::to_string(arguments.size()) + " arguments: must be " +
                          std::to_string(s.used.size()));
  int64_t count = 1;
  for (const int64_t d : shape) count *= d;
  if (count == 0) return;
  const int width = energy ? s.kernel.output_count(order) : s.get(static_cast<int>(order)).output_count();
  const int64_t together = blocks_together(width + s.unknowns.size() + s.elements.size());
  Packer unknowns(s.unknowns, arguments, together), elements(s.elements, arguments, together);
  AlignedVector<double> out(static_cast<size_t>(width * together * kLanes));
  std::vector<Walker> walkers;
  for (const StridedArray& array : arguments) walkers.emplace_back(array, shape);
  std::vector<std::array<int64_t, kLanes>> places(arguments.size());
  const Scatter scatter(s, order, out_results);
  for (int64_t begin = 0; begin < count; begin += together * kLanes) {
    const int64_t here = std::min(count - begin, together * kLanes);
    const int64_t blocks = (here + kLanes - 1) / kLanes;
    for (int64_t block = 0; block < blocks; ++block) {
      for (size_t a = 0; a < walkers.size(); ++a) {
        int64_t lanes[kLanes];
        walkers[a].next(count - begin - block * kLanes, lanes);
        std::copy_n(lanes, kLanes, places[a].begin());
      }
      unknowns.pack(block, places);
      elements.pack(block, places);
    }
    if (energy)
      s.kernel.evaluate(order, unknowns.data(), elements.data(), nullptr, out.data(), blocks);
    else
      s.get(static_cast<int>(order)).evaluate(unknowns.data(), elements.data(), nullptr, out.data(), blocks);
    for (int64_t e = 0; e < here; ++e)
      scatter.copy(out.data() + e / kLanes * width * kLanes, static_cast<int>(e % kLanes), begin + e);
  }
}

ArrayFunctionStatistics ArrayFunction::statistics(Order order) const {
  ArrayFunctionState& s = *state_;
  const int k = static_cast<int>(order);
  if (s.outputs.size() == 1) {
    const KernelStatistics& all = s.kernel.statistics();
    return {all.operations[k], all.instructions[k], all.code_bytes[k], all.build_seconds[k],
            order == Order::Hessian ? all.algorithm : ""};
  }
  if (order == Order::Hessian)
    throw InvalidArgument("statistics: a function of several outputs has no second derivatives");
  const FunctionStatistics& f = s.get(k).statistics();
  return {f.operations, f.instructions, f.code_bytes, f.build_seconds, ""};
}

StridedArray broadcast(const double* data, std::span<const int64_t> shape, std::span<const int64_t> strides,
                       size_t own, size_t batch) {
  const size_t lead = shape.size() - own;
  StridedArray result{data, std::vector<int64_t>(batch, 0), {0}};
  for (size_t d = 0; d < lead; ++d)
    if (shape[d] > 1) result.strides[batch - lead + d] = strides[d];
  for (size_t d = lead; d < shape.size(); ++d) {
    std::vector<int64_t> next;
    for (const int64_t offset : result.offsets)
      for (int64_t i = 0; i < shape[d]; ++i) next.push_back(offset + i * strides[d]);
    result.offsets = std::move(next);
  }
  return result;
}

}  // namespace stark::symbolic
