// Lists of the pairs that contact looks at, each complete while no site is farther than its margin from where
// its pairs were found. Sites that have moved farther are looked for anew, alone: where part of a scene
// moves, the rest costs nothing (step phases 2, 4b and 4h).
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include <stark/base/thread_pool.h>
#include <stark/base/timer.h>
#include <stark/collision/candidates.h>
#include <stark/collision/max_safe_step.h>
#include <stark/contact/edge_ranges.h>

namespace stark {

struct ContactCounters {
  int64_t candidate_builds = 0, swept_builds = 0;
  int64_t sites = 0;  ///< that were looked for in all builds
};

class CandidateSearch {
 public:
  /// group_distance: within the sum of two groups' values pairs act [m].
  CandidateSearch(SurfaceMesh mesh, PairFilter filter, std::span<const double> group_distance,
                  ThreadPool& pool, PhaseTimer& timer);
  CandidateSearch(CandidateSearch&&) noexcept;
  ~CandidateSearch();

  const SurfaceMesh& mesh() const;
  const PairFilter& filter() const;
  /// Pairs of edges act within a part of their contact distance, and collision detection keeps these
  /// distances [m], by group: farther ones are left out of the lists. Call it before the first one.
  void set_edges(std::shared_ptr<const EdgeRanges> ranges, std::span<const double> group_separation);
  /// Other pairs that may touch.
  void set_filter(PairFilter filter);

  /// All pairs that act with sites at x, and others, sorted. A reference to what the next call may change.
  const CandidateList& at(std::span<const Vec3> x);
  /// Pairs of edges that it leaves out although they are within their contact distance, and others, sorted.
  const CandidateList& distant_edges() const;
  /// The same as at(); its list stays, and that of a trial point is at hand where at() asks for it next.
  const CandidateList& at_trial(std::span<const Vec3> x);
  /// The same as at() where x is the point of the last at_trial().
  const CandidateList& at_accepted_trial(std::span<const Vec3> x);
  /// Largest part of the straight way from x0 to x1 that leads no pair into its separation, which is no more
  /// than its contact distance.
  double max_safe_step(std::span<const Vec3> x0, std::span<const Vec3> x1, const Separations& separations,
                       const CcdSettings& settings, CcdReport* out_report = nullptr);

  const ContactCounters& counters() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace stark
