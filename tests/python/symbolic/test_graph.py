"""Listings, counts and DOT text of formulas."""

from __future__ import annotations

import numpy as np

import stark.symbolic as sym


@sym.function
def sample(x: sym.Vector[2], a: float):
    r = sym.sqrt(x @ x + a)
    return sym.where((r > 1.0) & ~(a > x[0]), r * (a - 1.0), -r / 3.0)


def test_listing_names_shared_parts() -> None:
    lines = str(sample.graph()).splitlines()
    assert lines[0] == "sample(x[2], a):"
    assert lines[1] == "  t1 = sqrt(a + x[0]**2 + x[1]**2)"
    assert lines[-1] == "  return where((1 < t1) & ~(x[0] < a), t1 * (a - 1), -(t1 / 3))"


def test_listing_is_the_formula() -> None:
    """Run as Python, the listing gives the values of the function."""
    x, a = np.random.default_rng(2).uniform(0.0, 2.0, (2, 50)), 0.5
    scope = {"x": x, "a": a, "sqrt": np.sqrt, "where": np.where}
    *definitions, result = (line.strip() for line in str(sample.graph()).splitlines()[1:])
    for line in definitions:
        exec(line, scope)
    np.testing.assert_allclose(eval(result.removeprefix("return "), scope), sample(x.T, a), rtol=1e-14)


def test_counts() -> None:
    graph = sample.graph()
    assert graph.counts["*"] == 3
    assert graph.counts["sqrt"] == 1
    assert graph.operation_count == sum(graph.counts.values()) == sample.statistics.operations["value"]


def test_dot_text() -> None:
    text = sample.graph().dot()
    assert text.startswith('digraph "sample(x[2], a)" {')
    assert 'label="where", shape=ellipse' in text
    assert 'label="x[0]", shape=box' in text
    assert text.count("->") == sum(len(n.operands) for n in sample.graph().nodes.values()) + 1


def test_huge_formulas_print_quickly() -> None:
    @sym.function
    def tower(x: float):
        for _ in range(200):
            x = x * x + 0.5 * x
        return x

    text = str(tower.graph())
    assert len(text.splitlines()) == 201
    assert max(map(len, text.splitlines())) < 100


def test_several_outputs() -> None:
    @sym.function
    def pair(x: float):
        return [2.0 * x, 3.0]

    assert str(pair.graph()).splitlines()[-1] == "  return [2 * x, 3]"
    assert "ExpressionGraph of pair(x): 1 operations" in repr(pair.graph())


def test_node_access() -> None:
    x, a = sym.symbols("x a")
    product = 2.0 * (x + a)
    assert product.operation == "*"
    assert sorted(node.operation for node in product.operands) == ["+", "constant"]
    assert [node.name for node in product.operands[1].operands] == ["x", "a"]
    assert (x > a).is_condition
    assert not product.is_condition
    assert sym.sqrt(4.0).is_constant
    assert len(x.graph) > 2
