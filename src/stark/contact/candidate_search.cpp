#include <stark/contact/candidate_search.h>

#include <algorithm>
#include <iterator>
#include <utility>
#include <vector>

#include <stark/base/collect.h>
#include <stark/collision/broad_phase.h>
#include <stark/collision/distant_pairs.h>
#include <stark/contact/group_margins.h>
#include <stark/contact/site_margins.h>

namespace stark {

namespace {

/// Margin of a site over its contact distance. Longer motions are swept once instead of enlarging the list
/// that all energy evaluations read.
constexpr double kMarginFactor = 0.5;

/// Part of their margin from which sites are looked for anew together with those that are beyond it.
constexpr double kNearlyUsedUp = 0.5;

/// Edges with a core bear on it from so many times what collision detection keeps [theory eq. 16d].
constexpr double kEdgesBear = 2.0;

constexpr double kRounding = 1e-9;  ///< of distances, relative
constexpr int64_t kPairsPerTask = 2048;
constexpr int64_t kSitesPerTask = 8192;

struct Candidates {
  CandidateList list{};
  CandidateList distant{};       ///< pairs of edges that cannot act or meet within the margins
  SitePlaces places{};           ///< where each site was when its pairs were found
  std::vector<double> margin{};  ///< by group [m]
};

}  // namespace

struct CandidateSearch::Implementation {
  ThreadPool& pool;
  PhaseTimer& timer;
  BroadPhase broad_phase{};
  std::vector<double> reach{};  ///< by group [m]: distance and margin
  GroupMargins group_margins{};
  SiteMargins margins{};
  Candidates current{}, trial{};
  Candidates* at_trial = nullptr;  ///< the one that the last trial point was given, while it is there
  std::shared_ptr<const EdgeRanges> edge_ranges{};
  std::vector<double> separation{};  ///< by group [m]
  CandidateList found{}, found_distant{};
  std::vector<double> way_reach{};  ///< of the last find_way_reach() [m]
  std::vector<Vec3> part_end{};     ///< of the last end_of_part() [m]
  std::vector<uint8_t> moved{}, moved_in_trial{};
  uint64_t place_version = 0;
  ContactCounters counters{};

  const SurfaceMesh& mesh() const { return broad_phase.mesh(); }
  bool covers(const Candidates& candidates, std::span<const Vec3> x) const;
  /// Marks the sites that are to be looked for again in a list for x; returns how many.
  int64_t mark(const Candidates& candidates, std::span<const Vec3> x, std::vector<uint8_t>& out) const;
  /// Makes `out` a list for x of `base` and of what is found anew for the marked sites, and for those that
  /// what has moved leaves too small a margin.
  void renew(const Candidates& base, std::vector<uint8_t>& marked, std::span<const Vec3> x, Candidates& out);
  /// Where sites are when pairs are found for the marked ones, and their margins from there; marks more of
  /// them where these are smaller than before.
  void set_places(const Candidates& base, std::vector<uint8_t>& marked, std::span<const Vec3> x,
                  Candidates& out);
  /// The same of the one of both lists that needs less.
  void renew_nearer(std::span<const Vec3> x, Candidates& out);
  /// Whether two edges are too far apart to act, or for collision detection, before a site leaves its margin.
  bool is_distant(const PrimitivePair& edges, std::span<const Vec3> x) const;
  /// Moves pairs of edges from `found` to `found_distant`.
  void part_edges(std::span<const Vec3> x);
  /// Pairs of `base` without marked sites, and those found anew.
  void merge(const CandidateList& base, const CandidateList& anew, std::span<const uint8_t> marked,
             CandidateList& out);
  /// Pairs that come within the sum of their groups' separations [m] on the straight way from x0 to x1 and
  /// that the list of the last at() lacks, and others; none where it lacks none.
  const CandidateList* find_others(std::span<const Vec3> x0, std::span<const Vec3> x1,
                                   std::span<const double> group_separation);
  /// How far boxes are enlarged for a way, by group [m]: those of what rests as for lists, so that its tree
  /// serves both.
  std::span<const double> find_way_reach(std::span<const Vec3> x0, std::span<const Vec3> x1,
                                         std::span<const double> group_separation);
  /// Where a part of the way from x0 to x1 ends [m].
  std::span<const Vec3> end_of_part(std::span<const Vec3> x0, std::span<const Vec3> x1, double part);
};

CandidateSearch::CandidateSearch(SurfaceMesh mesh, PairFilter filter, std::span<const double> group_distance,
                                 ThreadPool& pool, PhaseTimer& timer)
    : implementation_(new Implementation{pool, timer}) {
  Implementation& self = *implementation_;
  std::vector<double> margin(group_distance.begin(), group_distance.end());
  for (double& m : margin) m *= kMarginFactor;
  self.group_margins = GroupMargins(group_distance, margin);
  self.margins = SiteMargins(mesh, &pool);
  self.reach.assign(group_distance.begin(), group_distance.end());
  for (double& r : self.reach) r *= 1.0 + kMarginFactor;
  self.broad_phase.reset(std::move(mesh), std::move(filter));
}

CandidateSearch::CandidateSearch(CandidateSearch&&) noexcept = default;
CandidateSearch::~CandidateSearch() = default;

const SurfaceMesh& CandidateSearch::mesh() const { return implementation_->mesh(); }
const PairFilter& CandidateSearch::filter() const { return implementation_->broad_phase.filter(); }
const ContactCounters& CandidateSearch::counters() const { return implementation_->counters; }

void CandidateSearch::set_filter(PairFilter filter) {
  implementation_->broad_phase.set_filter(std::move(filter));
  implementation_->current = implementation_->trial = {};
  implementation_->at_trial = nullptr;
}

void CandidateSearch::set_edges(std::shared_ptr<const EdgeRanges> ranges,
                                std::span<const double> group_separation) {
  implementation_->edge_ranges = std::move(ranges);
  implementation_->separation.assign(group_separation.begin(), group_separation.end());
}

const CandidateList& CandidateSearch::distant_edges() const { return implementation_->current.distant; }

bool CandidateSearch::Implementation::covers(const Candidates& candidates, std::span<const Vec3> x) const {
  return !candidates.places.x.empty() && margins.cover(candidates.margin, candidates.places.x, x);
}

int64_t CandidateSearch::Implementation::mark(const Candidates& candidates, std::span<const Vec3> x,
                                              std::vector<uint8_t>& out) const {
  if (candidates.places.x.empty()) {
    out.assign(x.size(), 1);
    return margins.site_count();
  }
  return margins.mark_beyond(kNearlyUsedUp, candidates.margin, candidates.places.x, x, out);
}

bool CandidateSearch::Implementation::is_distant(const PrimitivePair& edges, std::span<const Vec3> x) const {
  using Row = PairRow<PairKind::EdgeEdge>;
  const PrimitivePair groups = Row::groups(mesh(), edges);
  const double both = group_margins.least()[groups.first] + group_margins.least()[groups.second];
  const double distance = both / kMarginFactor;
  const double kept = separation[groups.first] + separation[groups.second];
  const double acts = std::max((*edge_ranges)(edges.first, edges.second) * distance, kEdgesBear * kept);
  const double least = (acts + both) * (1.0 + kRounding);
  return Row::squared_distance(Row::positions(mesh(), edges, x)) > least * least;
}

void CandidateSearch::Implementation::part_edges(std::span<const Vec3> x) {
  std::vector<PrimitivePair>&edges = found[PairKind::EdgeEdge], &distant = found_distant[PairKind::EdgeEdge];
  distant.clear();
  if (edge_ranges == nullptr) return;
  std::vector<uint8_t> is_far(edges.size());
  pool.for_each_range(static_cast<int64_t>(edges.size()), kPairsPerTask, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) is_far[i] = is_distant(edges[i], x);
  });
  size_t near = 0;
  for (size_t i = 0; i < edges.size(); ++i)
    if (is_far[i] != 0)
      distant.push_back(edges[i]);
    else
      edges[near++] = edges[i];
  edges.resize(near);
}

void CandidateSearch::Implementation::merge(const CandidateList& base, const CandidateList& anew,
                                            std::span<const uint8_t> marked, CandidateList& out) {
  for_each_pair_kind([&](auto kind) {
    const std::vector<PrimitivePair>&old = base[kind], &found_anew = anew[kind];
    const auto is_still = [&](const PrimitivePair& pair) {
      return std::ranges::none_of(PairRow<kind.value>::vertices(mesh(), pair),
                                  [&](int32_t site) { return marked[site] != 0; });
    };
    out[kind] = collect_ranges<PrimitivePair>(
        pool, std::ssize(old), kPairsPerTask, [&](int64_t first, int64_t last, auto& part) {
          const auto begin = old.begin() + first, end = old.begin() + last;
          const auto from =
              begin == old.begin() ? found_anew.begin() : std::ranges::lower_bound(found_anew, *begin);
          const auto to = end == old.end() ? found_anew.end() : std::ranges::lower_bound(found_anew, *end);
          std::vector<PrimitivePair> still;
          still.reserve(end - begin);
          std::copy_if(begin, end, std::back_inserter(still), is_still);
          part.resize(still.size() + (to - from));
          std::merge(still.begin(), still.end(), from, to, part.begin());
        });
  });
}

void CandidateSearch::Implementation::set_places(const Candidates& base, std::vector<uint8_t>& marked,
                                                 std::span<const Vec3> x, Candidates& out) {
  out.places.bounds.resize(reach.size());
  ++place_version;
  int64_t added = 0;
  const SitePlaces* from = &base.places;
  do {
    margins.place(*from, marked, x, place_version, out.places);
    from = &out.places;
    out.margin = group_margins.wide(broad_phase.filter(), out.places.bounds);
    added = margins.mark_more(out.margin, out.places.x, x, marked);
    counters.sites += added;
  } while (added > 0);
}

void CandidateSearch::Implementation::renew(const Candidates& base, std::vector<uint8_t>& marked,
                                            std::span<const Vec3> x, Candidates& out) {
  const PhaseTimer::Scope scope(timer, Phase::BroadPhase);
  set_places(base, marked, x, out);
  broad_phase.find(out.places.x, reach, pool, found, marked);
  // Rounding of the distance must not drop a pair at the very rim.
  std::vector<double> rim(reach);
  for (double& r : rim) r *= 1.0 + kRounding;
  remove_distant(mesh(), rim, out.places.x, pool, found);
  part_edges(out.places.x);
  merge(base.list, found, marked, out.list);
  merge(base.distant, found_distant, marked, out.distant);
  ++counters.candidate_builds;
}

void CandidateSearch::Implementation::renew_nearer(std::span<const Vec3> x, Candidates& out) {
  const int64_t count = mark(current, x, moved), in_trial = mark(trial, x, moved_in_trial);
  counters.sites += std::min(count, in_trial);
  if (count <= in_trial)
    renew(current, moved, x, out);
  else
    renew(trial, moved_in_trial, x, out);
}

const CandidateList& CandidateSearch::at(std::span<const Vec3> x) {
  Implementation& self = *implementation_;
  if (!self.covers(self.current, x)) {
    // The accepted trial point left a list behind.
    if (!self.covers(self.trial, x)) self.renew_nearer(x, self.trial);
    std::swap(self.current, self.trial);
    self.at_trial = nullptr;
  }
  return self.current.list;
}

const CandidateList& CandidateSearch::at_trial(std::span<const Vec3> x) {
  Implementation& self = *implementation_;
  self.at_trial = self.covers(self.current, x) ? &self.current : &self.trial;
  if (self.at_trial == &self.trial && !self.covers(self.trial, x)) self.renew_nearer(x, self.trial);
  return self.at_trial->list;
}

const CandidateList& CandidateSearch::at_accepted_trial(std::span<const Vec3> x) {
  Implementation& self = *implementation_;
  if (self.at_trial == nullptr) return at(x);
  if (self.at_trial == &self.trial) std::swap(self.current, self.trial);
  self.at_trial = nullptr;
  return self.current.list;
}

const CandidateList* CandidateSearch::Implementation::find_others(std::span<const Vec3> x0,
                                                                  std::span<const Vec3> x1,
                                                                  std::span<const double> group_separation) {
  if (covers(current, x1) && covers(current, x0)) return nullptr;
  const PhaseTimer::Scope scope(timer, Phase::BroadPhase);
  counters.sites += current.places.x.empty()
                        ? mark(current, x0, moved)
                        : margins.mark_leaving(current.margin, current.places.x, x0, x1, moved);
  broad_phase.find_swept(x0, x1, find_way_reach(x0, x1, group_separation), pool, found, moved);
  ++counters.swept_builds;
  return &found;
}

std::span<const double> CandidateSearch::Implementation::find_way_reach(
    std::span<const Vec3> x0, std::span<const Vec3> x1, std::span<const double> group_separation) {
  way_reach.assign(group_separation.begin(), group_separation.end());
  for (size_t group = 0; group < way_reach.size(); ++group) {
    const GroupFrame* frame = mesh().frame_of(static_cast<int32_t>(group));
    const auto rests = [&](int32_t site) { return x0[site] == x1[site]; };
    if (frame != nullptr && std::ranges::all_of(frame->sites, rests)) way_reach[group] = reach[group];
  }
  return way_reach;
}

std::span<const Vec3> CandidateSearch::Implementation::end_of_part(std::span<const Vec3> x0,
                                                                   std::span<const Vec3> x1, double part) {
  if (part == 1.0) return x1;
  part_end.resize(x0.size());
  pool.for_each_range(std::ssize(x0), kSitesPerTask, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) part_end[i] = x0[i] + (x1[i] - x0[i]) * part;
  });
  return part_end;
}

double CandidateSearch::max_safe_step(std::span<const Vec3> x0, std::span<const Vec3> x1,
                                      const Separations& separations, const CcdSettings& settings,
                                      CcdReport* out_report) {
  Implementation& self = *implementation_;
  CcdReport report;
  stark::max_safe_step(mesh(), self.current.list, x0, x1, separations, self.pool, &report, settings);
  // Most ways that end early end at pairs that were near before: others can only meet until that impact.
  CcdSettings until = settings;
  until.horizon = std::min(settings.horizon, report.step / (1.0 - settings.time_margin));
  if (until.horizon > 0.0) {
    const auto end = self.end_of_part(x0, x1, until.horizon);
    if (const CandidateList* others = self.find_others(x0, end, separations.by_group)) {
      CcdReport of_others;
      stark::max_safe_step(mesh(), *others, x0, x1, separations, self.pool, &of_others, until);
      if (of_others.step < report.step) report = of_others;
    }
  }
  if (out_report != nullptr) *out_report = report;
  return report.step;
}

}  // namespace stark
