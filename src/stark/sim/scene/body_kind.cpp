#include <stark/sim/scene/body_kind.h>

#include <stark/sim/scene/scene.h>

namespace stark {

const BodyKindRow& row_of(BodyKind kind) {
  static constexpr std::array kRows{
#define STARK_BODY_KIND(Kind, name) &k##Kind##Row,
#include <stark/sim/scene/body_kinds.inc>
  };
  return *kRows[static_cast<size_t>(kind)];
}

BodyElements elements_of(const Scene& scene, BodyId body) {
  const BodyKindRow& row = row_of(scene.kind(body));
  return row.elements ? row.elements(scene, body) : BodyElements{};
}

std::vector<Index2> edges_of(const Scene& scene, BodyId body) {
  const BodyElements elements = elements_of(scene, body);
  std::vector<Index2> edges;
  for (size_t e = 0; e < elements.count(); ++e)
    for (const Index2& edge : elements.edges)
      edges.push_back({elements.at(e)[edge[0]], elements.at(e)[edge[1]]});
  return edges;
}

}  // namespace stark
