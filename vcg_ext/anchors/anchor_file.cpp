// SPDX-License-Identifier: GPL-3.0-only
// Boost's own parser uses them, and says so each time it is compiled.
#define BOOST_BIND_GLOBAL_PLACEHOLDERS

#include "vcg_ext/anchors/anchor_file.h"

#include <algorithm>
#include <boost/property_tree/json_parser.hpp>
#include <boost/property_tree/ptree.hpp>
#include <boost/property_tree/xml_parser.hpp>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <locale>
#include <optional>
#include <sstream>

#include "vcg_ext/base/error.h"

namespace sphere_propagation {
namespace {

using Tree = boost::property_tree::ptree;

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

bool endsWith(const std::string& text, const std::string& ending) {
  return text.size() >= ending.size() &&
         text.compare(text.size() - ending.size(), ending.size(), ending) == 0;
}

std::string trimmed(const std::string& text) {
  constexpr const char* blanks = " \t\r\n";
  const size_t first = text.find_first_not_of(blanks);
  if (first == std::string::npos) return "";
  return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

std::filesystem::path pathOf(const std::string& text) { return std::filesystem::u8path(text); }

/// The number that a text is, be it nan or inf; nothing where it is none.
std::optional<double> numberIn(const std::string& given) {
  const std::string text = lower(trimmed(given));
  const std::string unsignedText =
      text.substr(!text.empty() && (text[0] == '+' || text[0] == '-') ? 1 : 0);
  if (unsignedText == "nan" || unsignedText == "inf" || unsignedText == "infinity")
    return std::nan("");
  std::istringstream stream(text[0] == '+' ? unsignedText : text);
  stream.imbue(std::locale::classic());
  double number = 0;
  if (!(stream >> number) || stream.peek() != std::istringstream::traits_type::eof())
    return std::nullopt;
  return number;
}

/// A place as a file has it.
struct Place {
  Vector3 point = Vector3::Zero();
  bool isThere = false, isWrong = false;
};

/// Empty or nan: not there; no number: wrong.
Place placeFrom(const std::vector<std::string>& texts) {
  Place place;
  if (texts.empty() || std::all_of(texts.begin(), texts.end(),
                                   [](const std::string& t) { return trimmed(t).empty(); }))
    return place;
  place.isWrong = texts.size() != 3;
  place.isThere = !place.isWrong;
  for (size_t k = 0; k < texts.size() && !place.isWrong; ++k) {
    const std::optional<double> number = numberIn(texts[k]);
    place.isWrong = !number;
    if (!number || !std::isfinite(*number))
      place.isThere = false;
    else
      place.point[static_cast<Eigen::Index>(k)] = *number;
  }
  return place;
}

/// What the readers have in common.
class Reader {
 public:
  explicit Reader(std::string file) : file_(std::move(file)) {
    std::error_code ignored;
    if (std::filesystem::is_directory(pathOf(file_), ignored)) fail(EISDIR);
    std::ifstream stream(pathOf(file_), std::ios::binary);
    if (!stream) fail(errno);
    std::ostringstream all;
    all << stream.rdbuf();
    text_ = all.str();
    if (text_.compare(0, 3, "\xEF\xBB\xBF") == 0) text_.erase(0, 3);
  }

  const std::string& text() const { return text_; }

  /// where: "line 4", "point 3".
  void add(AnchorList& list, const std::string& name, const std::vector<std::string>& texts,
           const std::string& where, bool isDefined = true) const {
    const Place place = placeFrom(texts);
    if (isDefined && place.isWrong)
      throw AnchorError(Finding(Fault::AnchorNotNumbers, file_).saying(where).against(name));
    if (!isDefined || !place.isThere) {
      list.undefined.push_back(name);
      return;
    }
    list.add(name, list.fromLps ? Vector3(-place.point[0], -place.point[1], place.point[2])
                                : place.point);
  }

  [[noreturn]] void failAt(unsigned long line, const std::string& words) const {
    throw AnchorError(
        Finding(Fault::AnchorFileSyntax, file_).of(0, static_cast<long>(line)).saying(words));
  }
  [[noreturn]] void holdsNone() const { throw AnchorError(Finding(Fault::NoAnchors, file_)); }
  /// What a file says of its frame.
  bool isLps(const std::string& system) const {
    const std::string known = lower(trimmed(system));
    if (known == "lps" || known == "1") return true;
    if (known == "ras" || known == "0") return false;
    throw AnchorError(Finding(Fault::AnchorFrame, file_).against(system));
  }

 private:
  [[noreturn]] void fail(int error) const {
    throw AnchorError(Finding(Fault::AnchorFileNotRead, file_)
                          .saying(error != 0 ? std::strerror(error) : "it cannot be opened"));
  }

  std::string file_, text_;
};

std::string textOf(const Tree& tree, const std::string& path) {
  return tree.get<std::string>(Tree::path_type(path, '/'), "");
}

std::string numbered(const std::string& name, size_t number) {
  return trimmed(name).empty() ? std::to_string(number) : trimmed(name);
}

std::string pointNumber(size_t number) { return "point " + std::to_string(number); }

AnchorList readPickPoints(const Reader& file) {
  Tree document;
  try {
    std::istringstream stream(file.text());
    boost::property_tree::read_xml(stream, document);
  } catch (const boost::property_tree::xml_parser_error& error) {
    file.failAt(error.line(), error.message());
  }
  const auto root = document.get_child_optional("PickedPoints");
  if (!root) file.holdsNone();
  AnchorList list;
  size_t number = 0;
  for (const auto& [tag, point] : *root) {
    if (tag != "point") continue;
    ++number;
    const auto attribute = [&, &at = point](const char* name) {
      return textOf(at, std::string("<xmlattr>/") + name);
    };
    file.add(list, numbered(attribute("name"), number),
             {attribute("x"), attribute("y"), attribute("z")}, pointNumber(number),
             attribute("active") != "0");
  }
  return list;
}

std::vector<std::string> textsIn(const Tree& list) {
  std::vector<std::string> texts;
  for (const auto& [key, entry] : list) texts.push_back(entry.data());
  return texts;
}

AnchorList readMarkups(const Reader& file, const Tree& lists) {
  AnchorList list;
  size_t number = 0;
  bool allLps = true;
  for (const auto& [key, markups] : lists) {
    const std::string system = textOf(markups, "coordinateSystem");
    list.fromLps = system.empty() || file.isLps(system);
    allLps = allLps && list.fromLps;
    const auto points = markups.get_child_optional("controlPoints");
    if (!points) continue;
    for (const auto& [ignored, point] : *points) {
      ++number;
      const std::string status = textOf(point, "positionStatus");
      const auto position = point.get_child_optional("position");
      file.add(list, numbered(textOf(point, "label"), number),
               position ? textsIn(*position) : std::vector<std::string>(), pointNumber(number),
               status.empty() || status == "defined");
    }
  }
  list.fromLps = allLps;
  return list;
}

AnchorList readJson(const Reader& file) {
  Tree document;
  try {
    std::istringstream stream(file.text());
    boost::property_tree::read_json(stream, document);
  } catch (const boost::property_tree::json_parser_error& error) {
    file.failAt(error.line(), error.message());
  }
  if (const auto markups = document.get_child_optional("markups"))
    return readMarkups(file, *markups);
  AnchorList list;  // scalismo's
  size_t number = 0;
  for (const auto& [key, point] : document) {
    const auto coordinates = point.get_child_optional("coordinates");
    if (!key.empty() || !coordinates || point.count("id") == 0) file.holdsNone();
    ++number;
    file.add(list, numbered(textOf(point, "id"), number), textsIn(*coordinates),
             pointNumber(number));
  }
  return list;
}

/// The fields of a line; "..." holds one that has a separator in it, and "" in that a quote.
std::vector<std::string> fieldsOf(const std::string& line, char separator) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (c == '"' && quoted && i + 1 < line.size() && line[i + 1] == '"') {
      fields.back() += line[++i];
    } else if (c == '"' && (quoted || trimmed(fields.back()).empty())) {
      quoted = !quoted;
    } else if (c == separator && !quoted) {
      fields.emplace_back();
    } else if (c == '\t' && separator == ' ' && !quoted) {
      fields.emplace_back();
    } else {
      fields.back() += c;
    }
  }
  for (std::string& field : fields) field = trimmed(field);
  if (separator == ' ')  // of which several are as one
    fields.erase(std::remove(fields.begin(), fields.end(), ""), fields.end());
  return fields;
}

struct Line {
  size_t number;
  std::string text;
};

/// The lines that say something. comments: those that begin with #.
std::vector<Line> linesOf(const std::string& text, std::vector<Line>& comments) {
  std::vector<Line> lines;
  std::istringstream stream(text);
  size_t number = 0;
  for (std::string line; std::getline(stream, line);) {
    ++number;
    if (trimmed(line).empty()) continue;
    (trimmed(line)[0] == '#' ? comments : lines).push_back({number, line});
  }
  return lines;
}

std::string lineNumber(const Line& line) { return "line " + std::to_string(line.number); }

/// 3D Slicer's fields, as the line "# columns" of its files has them; older files have the label
/// first.
AnchorList readFiducials(const Reader& file) {
  std::vector<Line> comments;
  const std::vector<Line> lines = linesOf(file.text(), comments);
  AnchorList list;
  bool hasVersion = false;
  std::vector<std::string> columns = {"label", "x", "y", "z"};
  for (const Line& line : comments) {
    const size_t equals = line.text.find('=');
    if (equals == std::string::npos) continue;
    const std::string key = lower(line.text.substr(0, equals)),
                      value = trimmed(line.text.substr(equals + 1));
    if (key.find("coordinatesystem") != std::string::npos) list.fromLps = file.isLps(value);
    if (key.find("version") != std::string::npos) hasVersion = true;
    if (key.find("columns") != std::string::npos) columns = fieldsOf(value, ',');
  }
  const auto column = [&](const char* name) {
    return static_cast<size_t>(std::find(columns.begin(), columns.end(), name) - columns.begin());
  };
  size_t number = 0;
  for (const Line& line : lines) {
    ++number;
    const std::vector<std::string> fields = fieldsOf(line.text, ',');
    const auto field = [&](size_t at) { return at < fields.size() ? fields[at] : ""; };
    // Behind the columns that it names, Slicer 5 writes a status: 2 is a point that is there.
    constexpr size_t statusColumn = 14;
    const std::string status = hasVersion ? field(statusColumn) : "";
    file.add(list, numbered(field(column("label")), number),
             {field(column("x")), field(column("y")), field(column("z"))}, lineNumber(line),
             status.empty() || status == "2");
  }
  return list;
}

/// Which columns of a table hold what; none of `name` where places have no names.
struct Columns {
  std::optional<size_t> name;
  size_t x = 0, y = 0, z = 0;
};

/// The columns that a first line of words names; nothing where it names no places. What stands
/// before them without a word that is known are names, too, as in tables that R writes.
std::optional<Columns> columnsFrom(const std::vector<std::string>& header) {
  std::optional<size_t> name, place[3];
  for (size_t i = 0; i < header.size(); ++i) {
    const std::string word = lower(header[i]);
    if (word == "name" || word == "label" || word == "landmark" || (word == "id" && !name))
      name = i;
    for (size_t k = 0; k < 3; ++k)
      if (word == std::string(1, static_cast<char>('x' + k)) && !place[k]) place[k] = i;
  }
  if (!place[0] || !place[1] || !place[2]) return std::nullopt;
  if (!name && std::min({*place[0], *place[1], *place[2]}) > 0) name = 0;
  return Columns{name, *place[0], *place[1], *place[2]};
}

bool isPlaceholder(const std::string& text) { return text.empty() || numberIn(text).has_value(); }

/// The separator of a table's columns.
char separatorOf(const std::string& line) {
  char separator = ' ';
  for (const char candidate : {'\t', ';', ','})
    if (line.find(candidate) != std::string::npos) separator = candidate;
  return separator;
}

AnchorList readTable(const Reader& file) {
  std::vector<Line> comments;
  const std::vector<Line> lines = linesOf(file.text(), comments);
  AnchorList list;
  if (lines.empty()) return list;
  const char separator = separatorOf(lines[0].text);
  std::optional<Columns> columns = columnsFrom(fieldsOf(lines[0].text, separator));
  size_t number = 0;
  for (size_t i = columns ? 1 : 0; i < lines.size(); ++i) {
    std::vector<std::string> fields = fieldsOf(lines[i].text, separator);
    std::string name;
    std::vector<std::string> place;
    ++number;
    if (columns) {
      const auto field = [&](size_t at) { return at < fields.size() ? fields[at] : ""; };
      if (columns->name) name = field(*columns->name);
      place = {field(columns->x), field(columns->y), field(columns->z)};
    } else if (separator == ' ' && fields.size() > 3) {  // a name may have blanks in it
      for (size_t k = 0; k + 3 < fields.size(); ++k) name += (k > 0 ? " " : "") + fields[k];
      place.assign(fields.end() - 3, fields.end());
    } else if (fields.size() > 3) {
      name = fields[0];
      place.assign(fields.begin() + 1, fields.begin() + 4);
      // x, y, z and more: there are no names.
      if (!isPlaceholder(place[2]) && isPlaceholder(name)) {
        place.assign(fields.begin(), fields.begin() + 3);
        name.clear();
      }
    } else {
      place = fields;
    }
    if (place.size() < 3) place.resize(3, "?");  // no place at all
    file.add(list, numbered(name, number), place, lineNumber(lines[i]));
  }
  return list;
}

/// A table of longitudes and latitudes in degrees, as unit vectors; nothing where its first line
/// names no such columns.
std::optional<AnchorList> readLongitudes(const Reader& file) {
  std::vector<Line> comments;
  const std::vector<Line> lines = linesOf(file.text(), comments);
  if (lines.empty()) return std::nullopt;
  const char separator = separatorOf(lines[0].text);
  std::optional<size_t> name, longitude, latitude;
  const std::vector<std::string> header = fieldsOf(lines[0].text, separator);
  for (size_t i = 0; i < header.size(); ++i) {
    const std::string word = lower(header[i]);
    if (word == "name" || word == "label" || word == "landmark") name = i;
    if (word == "longitude" || word == "lon") longitude = i;
    if (word == "latitude" || word == "lat") latitude = i;
  }
  if (!longitude || !latitude) return std::nullopt;
  AnchorList degrees, list;
  for (size_t i = 1; i < lines.size(); ++i) {
    const std::vector<std::string> fields = fieldsOf(lines[i].text, separator);
    const auto field = [&](size_t at) { return at < fields.size() ? fields[at] : ""; };
    const std::string east = field(*longitude), north = field(*latitude);
    file.add(degrees, numbered(name ? field(*name) : "", i),
             {east, north, east.empty() && north.empty() ? "" : "0"}, lineNumber(lines[i]));
  }
  list.undefined = degrees.undefined;
  list.ambiguous = degrees.ambiguous;
  for (const auto& [anchor, place] : degrees.anchors) {
    requireRange("latitude of \"" + anchor + "\"", place[1], Range::between(-90, 90));
    const double east = place[0] * pi / 180, north = place[1] * pi / 180;
    list.anchors[anchor] = Vector3(std::cos(north) * std::cos(east),
                                   std::cos(north) * std::sin(east), std::sin(north));
  }
  return list;
}

const std::vector<std::string> tableEndings{".csv", ".tsv", ".txt", ".pts", ".xyz", ".particles"};

/// Where anchors of NAME are looked for.
std::vector<std::string> namesFor(const std::string& name) {
  return {name + "_picked_points.pp", name + ".mrk.json", name + ".csv", name + ".fcsv",
          name + ".pp"};
}

bool isFile(const std::filesystem::path& path) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(path, ignored);
}

AnchorList readByEnding(const std::string& file) {
  const std::string name = lower(file);
  const auto isOf = [&](const std::string& ending) { return endsWith(name, ending); };
  if (isOf(".pp")) return readPickPoints(Reader(file));
  if (isOf(".json")) return readJson(Reader(file));
  if (isOf(".fcsv")) return readFiducials(Reader(file));
  if (std::any_of(tableEndings.begin(), tableEndings.end(), isOf)) return readTable(Reader(file));
  throw AnchorError(Finding(Fault::AnchorFileUnknown, file));
}

/// A file that was written before a point was placed must not pass for one that says something.
AnchorList unlessEmpty(AnchorList list, const std::string& file) {
  if (list.anchors.empty() && list.undefined.empty() && list.ambiguous.empty())
    throw AnchorError(Finding(Fault::NoAnchors, file));
  return list;
}

}  // namespace

AnchorList readAnchors(const std::string& file) { return unlessEmpty(readByEnding(file), file); }

AnchorList readSpherePlaces(const std::string& file) {
  const std::string name = lower(file);
  if (std::any_of(tableEndings.begin(), tableEndings.end(),
                  [&](const std::string& ending) { return endsWith(name, ending); }))
    if (std::optional<AnchorList> list = readLongitudes(Reader(file)))
      return unlessEmpty(std::move(*list), file);
  AnchorList list = readAnchors(file);
  for (auto& [anchor, place] : list.anchors) {
    requireRange("length of the direction of \"" + anchor + "\"", place.norm(), Range::above(0));
    place.normalize();
  }
  return list;
}

std::vector<std::string> anchorFilesBeside(const std::string& mesh) {
  std::vector<std::string> files;
  const std::filesystem::path path = pathOf(mesh);
  if (path.filename().empty()) return files;
  for (const std::string& name : namesFor(path.stem().u8string())) {
    const std::filesystem::path file = path.parent_path() / pathOf(name);
    if (isFile(file)) files.push_back(file.u8string());
  }
  return files;
}

std::vector<std::string> anchorFilesIn(const std::string& folder, const std::string& name) {
  std::vector<std::string> stems{name}, files;
  if (const std::string stem = pathOf(name).stem().u8string(); stem != name) stems.push_back(stem);
  for (const std::string& stem : stems) {
    std::vector<std::string> names = namesFor(stem);
    names.push_back(stem + ".json");
    for (const std::string& ending : tableEndings)
      if (ending != ".csv") names.push_back(stem + ending);
    for (const std::string& candidate : names)
      if (const std::filesystem::path file = pathOf(folder) / pathOf(candidate); isFile(file))
        files.push_back(file.u8string());
  }
  return files;
}

}  // namespace sphere_propagation
