#pragma once
/// What is set in the lab: "panel=solve&weight=100&frames=4", as in the page's address after the #.

#include <initializer_list>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace ch5::lab {

/// A setting that cannot be used, for a page to put in its own language.
struct QueryFault {
  std::string setting, value;
  std::string kind;    ///< what it must be: "number", "whole number", "one of", "list"; "setting" if it is unknown here
  std::string limits;  ///< "0 to 5", or the words of "one of"

  std::string Sentence() const;
};

/// Nothing here throws, since WebAssembly is compiled without catching: the first fault is kept, and what
/// was read then is the default.
class Query {
 public:
  /// "4:0.5:-1" is {4, {0.5, −1}}.
  struct Item {
    int number = 0;
    std::vector<double> reals;
  };

  explicit Query(const std::string& text);

  /// The value of `name`, or `usual` where it is not given; a number outside of [low, high] is a fault.
  double Number(const std::string& name, double usual, double low, double high);
  int Whole(const std::string& name, int usual, int low, int high);
  /// The position of the value among `words`, the first of which is the default.
  int Word(const std::string& name, std::initializer_list<const char*> words);
  /// "3,0,7"; none by default.
  std::vector<int> Numbers(const std::string& name, int low, int high);
  /// "2:0.5:-1,4:0:0.3": items of a whole number ≥ 0 and `reals` numbers from −20 to 20; none by default.
  std::vector<Item> Items(const std::string& name, size_t reals);

  /// Call this after everything has been read: a name that was never read is a fault too. @return whether there is no fault
  bool IsGood();
  const std::optional<QueryFault>& Fault() const { return fault_; }

 private:
  struct Entry {
    std::string value;
    bool is_read = false;
  };

  const std::string* Find(const std::string& name);
  void Refuse(const std::string& name, const std::string& kind, const std::string& limits);

  std::map<std::string, Entry> entries_;
  std::optional<QueryFault> fault_;
};

}  // namespace ch5::lab
