// Reference evaluation by the standard library, printing, and compiled functions.
// Phase: model building and post-processing.
#include <stark/symbolic/evaluate.h>

#include <stark/base/error.h>
#include <stark/symbolic/backend/executable.h>
#include <stark/symbolic/diff.h>
#include <stark/symbolic/lower.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <utility>

namespace stark::symbolic {

namespace {

double input_value(std::span<const double> values, NodeId index, const char* kind) {
  if (index >= static_cast<NodeId>(values.size())) {
    throw InvalidArgument("evaluate: the expression uses " + std::string(kind) + " input " +
                          std::to_string(index) + ", but only " + std::to_string(values.size()) +
                          " values were given.");
  }
  return values[index];
}

double evaluate_node(const Node& n, const double* x, const InputValues& in) {
  switch (n.op) {
    case Op::Constant:
      return n.value;
    case Op::Unknown:
      return input_value(in.unknowns, n.operands[0], "unknown");
    case Op::Element:
      return input_value(in.elements, n.operands[0], "element");
    case Op::Uniform:
      return input_value(in.uniforms, n.operands[0], "uniform");
    case Op::Neg:
      return -x[0];
    case Op::Held:
      return x[0];
    case Op::Abs:
      return std::fabs(x[0]);
    case Op::Sqrt:
      return std::sqrt(x[0]);
    case Op::Exp:
      return std::exp(x[0]);
    case Op::Log:
      return std::log(x[0]);
    case Op::Sin:
      return std::sin(x[0]);
    case Op::Cos:
      return std::cos(x[0]);
    case Op::Tan:
      return std::tan(x[0]);
    case Op::Asin:
      return std::asin(x[0]);
    case Op::Acos:
      return std::acos(x[0]);
    case Op::Atan:
      return std::atan(x[0]);
    case Op::Tanh:
      return std::tanh(x[0]);
    case Op::Add:
      return x[0] + x[1];
    case Op::Sub:
      return x[0] - x[1];
    case Op::Mul:
      return x[0] * x[1];
    case Op::Div:
      return x[0] / x[1];
    case Op::Min:
      return std::isnan(x[0]) || x[0] < x[1] ? x[0] : x[1];
    case Op::Max:
      return std::isnan(x[0]) || x[0] > x[1] ? x[0] : x[1];
    case Op::Pow:
      return std::pow(x[0], x[1]);
    case Op::Atan2:
      return std::atan2(x[0], x[1]);
    case Op::Fma:
      return std::fma(x[0], x[1], x[2]);
    case Op::Select:
      return x[0] != 0.0 ? x[1] : x[2];
    case Op::Less:
      return x[0] < x[1];
    case Op::LessEqual:
      return x[0] <= x[1];
    case Op::And:
      return x[0] != 0.0 && x[1] != 0.0;
    case Op::Or:
      return x[0] != 0.0 || x[1] != 0.0;
    case Op::Not:
      return x[0] == 0.0;
  }
  return 0.0;
}

double evaluate_any(const Scalar& expression, const InputValues& values) {
  if (expression.is_literal()) return expression.value();
  const Graph& graph = *expression.graph();
  std::vector<char> needed(expression.id() + 1, 0);
  needed[expression.id()] = 1;
  for (NodeId id = expression.id(); id >= 0; --id) {
    if (!needed[id]) continue;
    const Node& n = graph.node(id);
    for (int k = 0; k < operand_count(n.op); ++k) needed[n.operands[k]] = 1;
  }
  std::vector<double> result(expression.id() + 1, 0.0);
  for (NodeId id = 0; id <= expression.id(); ++id) {
    if (!needed[id]) continue;
    const Node& n = graph.node(id);
    double x[3] = {0.0, 0.0, 0.0};
    for (int k = 0; k < operand_count(n.op); ++k) x[k] = result[n.operands[k]];
    result[id] = evaluate_node(n, x, values);
  }
  return result[expression.id()];
}

std::string number_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.17g", value);
  char shorter[32];
  std::snprintf(shorter, sizeof shorter, "%.15g", value);
  return std::strtod(shorter, nullptr) == value ? shorter : text;
}

// Writes infix text until it is longer than a limit.
class Printer {
 public:
  Printer(const Graph& graph, size_t limit) : graph_(graph), limit_(limit) {}

  void write(NodeId id) {
    if (text_.size() > limit_) return;
    const Node& n = graph_.node(id);
    const std::string name = graph_.name(id);
    if (!name.empty()) {
      text_ += name;
    } else if (n.op == Op::Constant) {
      text_ += number_text(n.value);
    } else if (operand_count(n.op) == 0) {
      text_ += (n.op == Op::Unknown ? "u" : n.op == Op::Element ? "e" : "p") + std::to_string(n.operands[0]);
    } else if (n.op == Op::Neg || n.op == Op::Not) {
      text_ += n.op == Op::Neg ? "-" : "!";
      write(n.operands[0]);
    } else {
      write_operation(n);
    }
  }

  std::string take() {
    if (text_.size() > limit_) text_ = text_.substr(0, limit_) + "...";
    return std::move(text_);
  }

 private:
  void write_operation(const Node& n) {
    const std::string name = name_of(n.op);
    const bool infix = std::string("+-*/<&|").find(name[0]) != std::string::npos;
    text_ += infix ? "(" : name + "(";
    for (int k = 0; k < operand_count(n.op); ++k) {
      if (k > 0) text_ += infix ? " " + name + " " : ", ";
      write(n.operands[k]);
    }
    text_ += ")";
  }

  const Graph& graph_;
  size_t limit_;
  std::string text_;
};

}  // namespace

double evaluate(const Scalar& expression, const InputValues& values) {
  if (expression.is_condition())
    throw InvalidArgument("evaluate: the expression is a condition; use evaluate_condition.");
  return evaluate_any(expression, values);
}

bool evaluate_condition(const Scalar& condition, const InputValues& values) {
  if (!condition.is_condition())
    throw InvalidArgument("evaluate_condition: the expression is a number; use evaluate.");
  return evaluate_any(condition, values) != 0.0;
}

std::string name_of(Op op) {
  switch (op) {
    case Op::Constant:
    case Op::Unknown:
    case Op::Element:
    case Op::Uniform:
      return "";
    case Op::Neg:
      return "neg";
    case Op::Held:
      return "held";
    case Op::Abs:
      return "abs";
    case Op::Sqrt:
      return "sqrt";
    case Op::Exp:
      return "exp";
    case Op::Log:
      return "log";
    case Op::Sin:
      return "sin";
    case Op::Cos:
      return "cos";
    case Op::Tan:
      return "tan";
    case Op::Asin:
      return "asin";
    case Op::Acos:
      return "acos";
    case Op::Atan:
      return "atan";
    case Op::Tanh:
      return "tanh";
    case Op::Add:
      return "+";
    case Op::Sub:
      return "-";
    case Op::Mul:
      return "*";
    case Op::Div:
      return "/";
    case Op::Min:
      return "min";
    case Op::Max:
      return "max";
    case Op::Pow:
      return "pow";
    case Op::Atan2:
      return "atan2";
    case Op::Fma:
      return "fma";
    case Op::Select:
      return "select";
    case Op::Less:
      return "<";
    case Op::LessEqual:
      return "<=";
    case Op::And:
      return "&&";
    case Op::Or:
      return "||";
    case Op::Not:
      return "not";
  }
  return "";
}

std::string to_string(const Scalar& expression, size_t limit) {
  if (expression.is_literal()) {
    return expression.is_condition() ? (expression.value() != 0.0 ? "true" : "false")
                                     : number_text(expression.value());
  }
  Printer printer(*expression.graph(), limit);
  printer.write(expression.id());
  return printer.take();
}

struct FunctionState {
  std::unique_ptr<Executable> code;
  int unknown_count = 0, element_count = 0, uniform_count = 0, output_count = 0;
  Backend backend = Backend::Interpreter;
  FunctionStatistics statistics;
};

int Function::unknown_count() const { return state_->unknown_count; }
int Function::element_count() const { return state_->element_count; }
int Function::uniform_count() const { return state_->uniform_count; }
int Function::output_count() const { return state_->output_count; }
Backend Function::backend() const { return state_->backend; }
const FunctionStatistics& Function::statistics() const { return state_->statistics; }

void Function::evaluate(const double* unknowns, const double* elements, const double* uniforms,
                        double* out_values, int64_t block_count) const {
  state_->code->run(unknowns, elements, uniforms, out_values, block_count);
}

namespace {

/// The one graph of all outputs, null if all are numbers.
Graph* graph_of(std::span<const std::vector<Scalar>> groups) {
  Graph* graph = nullptr;
  for (const auto& group : groups) {
    for (const Scalar& s : group) {
      if (s.is_condition())
        throw InvalidArgument("compile_function: an output is a condition; use select(condition, 1.0, 0.0).");
      if (s.is_literal()) continue;
      if (graph && s.graph() != graph)
        throw InvalidArgument(
            "compile_function: the outputs belong to different graphs; build them in one graph.");
      graph = s.graph();
    }
  }
  return graph;
}

}  // namespace

Function compile_function(std::span<const Scalar> outputs, Backend backend) {
  const std::vector<Scalar> group(outputs.begin(), outputs.end());
  return compile_function(std::span(&group, 1), backend);
}

Function compile_function(std::span<const std::vector<Scalar>> groups, Backend backend) {
  const auto begin = std::chrono::steady_clock::now();
  const Graph* source = graph_of(groups);
  Graph own;
  std::vector<NodeId> roots;
  for (const auto& group : groups) {
    for (const Scalar& s : group) {
      if (!s.is_literal()) roots.push_back(s.id());
    }
  }
  std::vector<NodeId> images;
  if (source) images = import_expressions(*source, roots, own);
  std::vector<std::vector<NodeId>> nodes;
  std::vector<NodeId> outputs;
  size_t next = 0;
  for (const auto& group : groups) {
    nodes.emplace_back();
    for (const Scalar& s : group)
      nodes.back().push_back(s.is_literal() ? own.constant(s.value()) : images[next++]);
    outputs.insert(outputs.end(), nodes.back().begin(), nodes.back().end());
  }
  const Program program = lower(own, nodes);
  auto state = std::make_shared<FunctionState>();
  state->code = make_executable(program, resolve_backend(backend), state->backend);
  state->unknown_count = program.unknown_count;
  state->element_count = program.element_count;
  state->uniform_count = program.uniform_count;
  state->output_count = static_cast<int>(outputs.size());
  state->statistics.operations = operation_total(own, outputs);
  state->statistics.instructions = static_cast<int>(program.instructions.size());
  state->statistics.code_bytes = state->code->code_bytes;
  state->statistics.build_seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  Function f;
  f.state_ = std::move(state);
  return f;
}

}  // namespace stark::symbolic
