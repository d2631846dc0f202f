// What contact knows of the loads that two bodies press each other with, from step to step. [theory eq. 18a]
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <stark/base/math.h>

namespace stark {

/// Whether stiffer contact opens the gap, as it does under a load, or raises the force instead, as between
/// jaws that nothing moves. [theory eq. 18b]
struct LoadTrial {
  double factor = 0.0;    ///< at its start; 0: there is no trial
  double pressing = 0.0;  ///< what the load asked for over that factor, at its start
  double most = 0.0;      ///< largest factor until the gap has opened
  double age = 0.0;       ///< since stiffer contact opened the gap last, over the delay of factors

  bool operator==(const LoadTrial&) const = default;
};

/// Pairs of bodies whose load asks for stiffer contact, and by how much. One factor for all contacts of two
/// bodies: were each to follow its own load, all would be carried at the same gap and nothing would hold the
/// distribution of a load over many contacts. Part of the State; sorted, without doubles.
struct LoadMemory {
  std::vector<int64_t> bodies;   ///< group_code()
  std::vector<double> factor;    ///< up to 1 the load has not lasted long enough
  std::vector<LoadTrial> trial;  ///< by pair

  LoadMemory() = default;
  /// trials: factor, pressing and most of each; those and their ages may be empty, as in older states.
  LoadMemory(std::vector<int64_t> pairs, std::vector<double> factors, std::span<const Vec3> trials,
             std::span<const double> ages);

  double find(int64_t code) const;     ///< that acts: at least 1
  double pending(int64_t code) const;  ///< as it is known, the smallest one when nothing is
  LoadTrial trial_of(int64_t code) const;
  void add(int64_t code, double value, const LoadTrial& trial = {});  ///< codes in ascending order
  /// Adds what the load of a step asks of the next one: `wanted`, in the same terms as the factor of
  /// `before`. duration: of the step, over the delay with which factors follow.
  void follow(const LoadMemory& before, int64_t code, double wanted, double duration);

  bool has_trials() const;
  std::vector<Vec3> trials() const;  ///< empty without any, as trial_ages()
  std::vector<double> trial_ages() const;

 private:
  std::optional<size_t> place(int64_t code) const;  ///< in the lists above
};

}  // namespace stark
