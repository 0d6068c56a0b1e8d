#pragma once
/// What is set in the lab: "panel=solve&weight=100&frames=4", as it stands in the page's address behind the #.

#include <initializer_list>
#include <map>
#include <string>
#include <vector>

namespace ch5::lab {

/// Nothing here throws, since WebAssembly is compiled without catching: the first fault is kept as a sentence, and what
/// was read then is the default.
class Query {
 public:
  explicit Query(const std::string& text);

  /// The value of `name`, or `usual` where it is not given; a number outside of [low, high] is a fault.
  double Number(const std::string& name, double usual, double low, double high);
  int Whole(const std::string& name, int usual, int low, int high);
  /// The position of the value among `words`, the first of which is the default.
  int Word(const std::string& name, std::initializer_list<const char*> words);
  /// "3,0,7"; none by default.
  std::vector<int> Numbers(const std::string& name, int low, int high);

  /// To be called when all has been read: a name that nobody asked for is a fault too. @return whether there is none
  bool IsGood();
  const std::string& Fault() const { return fault_; }

 private:
  struct Entry {
    std::string value;
    bool is_read = false;
  };

  const std::string* Find(const std::string& name);
  void Refuse(const std::string& name, const std::string& value, const std::string& wanted);

  std::map<std::string, Entry> entries_;
  std::string fault_;
};

}  // namespace ch5::lab
