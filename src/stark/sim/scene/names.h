// Names of the bodies, energies or joints of a scene: which are taken, and the next free one of a stem.
#pragma once

#include <map>
#include <set>
#include <string>

namespace stark {

class Names {
 public:
  bool contains(const std::string& name) const { return taken_.contains(name); }
  void add(const std::string& name) { taken_.insert(name); }

  /// `stem`, or the first of stem_2, stem_3, ... that is free. The search goes on where the last one ended,
  /// as names are never given back: adding n things of one stem takes O(n log n).
  std::string next(const std::string& stem) {
    if (!contains(stem)) return stem;
    int& number = numbers_.try_emplace(stem, 2).first->second;
    while (contains(stem + "_" + std::to_string(number))) ++number;
    return stem + "_" + std::to_string(number);
  }

 private:
  std::set<std::string> taken_;
  std::map<std::string, int> numbers_;  ///< where to go on, by stem
};

}  // namespace stark
