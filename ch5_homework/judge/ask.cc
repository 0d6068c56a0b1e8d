#include "ch5_homework/judge/ask.h"

#include "ch5_homework/judge/checks/check.h"

namespace ch5::homework {

Answer Ask(const std::string& check, const Values& given) { return Run(check, Chosen(), given); }

}  // namespace ch5::homework
