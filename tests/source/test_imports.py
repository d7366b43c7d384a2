"""Structure of the source: every module can be read without those that use it."""

from __future__ import annotations

import grimp


def circles(graph: grimp.ImportGraph) -> list[set[str]]:
    """Return the groups of modules that import each other, directly or through others."""
    reached = {module: graph.find_upstream_modules(module) for module in graph.modules}
    groups: list[set[str]] = []
    for module, upstream in reached.items():
        group = {module, *(other for other in upstream if module in reached[other])}
        if len(group) > 1 and group not in groups:
            groups.append(group)
    return groups


def test_no_modules_import_each_other():
    """Imports form no circle, those for type checking included."""
    graph = grimp.build_graph("lostmotion", exclude_type_checking_imports=False)
    assert len(graph.modules) > 100
    assert circles(graph) == []


def test_a_circle_would_be_found():
    """Three modules in a circle are one group; a fourth that only imports them is in none."""
    graph = grimp.ImportGraph()
    for importer, imported in (("a", "b"), ("b", "c"), ("c", "a"), ("d", "a")):
        graph.add_import(importer=importer, imported=imported)
    assert circles(graph) == [{"a", "b", "c"}]
