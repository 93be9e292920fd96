// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/base/sentence.h"

#include <cmath>
#include <limits>
#include <locale>
#include <sstream>

namespace sphere_propagation {

std::string fill(std::string_view text,
                 const std::function<std::string(std::string_view gap)>& valueOf) {
  std::string filled;
  if (const size_t begin = text.find('['), end = text.find(']', begin); end != text.npos) {
    bool complete = true;
    const std::string inside =
        fill(text.substr(begin + 1, end - begin - 1), [&](std::string_view gap) {
          std::string value = valueOf(gap);
          complete = complete && !value.empty();
          return value;
        });
    return fill(text.substr(0, begin), valueOf) + (complete ? inside : std::string()) +
           fill(text.substr(end + 1), valueOf);
  }
  while (!text.empty()) {
    const size_t open = text.find('{'), close = text.find('}', open);
    if (open == std::string_view::npos || close == std::string_view::npos) break;
    filled += text.substr(0, open);
    const std::string_view gap = text.substr(open + 1, close - open - 1);
    const size_t one = gap.find('|'), many = gap.rfind('|');
    const std::string value = valueOf(gap.substr(0, one));
    filled += value;
    if (one != std::string_view::npos) {
      filled += ' ';
      filled += value == "1" ? gap.substr(one + 1, many - one - 1) : gap.substr(many + 1);
    }
    text.remove_prefix(close + 1);
  }
  return filled += text;
}

std::string numeral(double value, int digits) {
  constexpr double exact = 1e15;  // integers up to here are doubles with digits to spare
  const bool whole = std::fabs(value) < exact && value == std::floor(value);
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text.precision(whole ? std::numeric_limits<double>::digits10 : digits);
  text << value;
  return text.str();
}

}  // namespace sphere_propagation
