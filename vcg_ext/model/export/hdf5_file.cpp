// SPDX-License-Identifier: GPL-3.0-only
// Names in comments are those of the specification. All addresses count from the beginning of the
// file; every structure begins at a multiple of 8.

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "vcg_ext/model/export/bytes.h"
#include "vcg_ext/model/export/hdf5.h"

namespace sphere_propagation {
namespace {

using Address = std::uint64_t;

constexpr Address undefined = ~Address{0};
/// A symbol table node holds 2 leafK entries, a B-tree node 2 internalK.
constexpr int leafK = 4, internalK = 16;
constexpr size_t superblockSize = 96;

std::string aligned(std::string text) {
  text.resize((text.size() + 7) / 8 * 8, '\0');
  return text;
}

/// Dataspace message, version 1.
std::string dataspace(const std::vector<Eigen::Index>& extents) {
  Bytes message;
  message.put(1, 1).put(extents.size(), 1).put(0, 6);
  for (const Eigen::Index extent : extents) message.put(static_cast<std::uint64_t>(extent), 8);
  return message.str();
}

/// Datatype messages, version 1: class, bit field, size, properties.
std::string integerType() {
  return Bytes().put(0x10, 1).put(0x08, 3).put(4, 4).put(0, 2).put(32, 2).str();
}

std::string floatType() {
  return Bytes()
      .put(0x11, 1)
      .put(0x1f20, 3)  // sign in bit 31, the mantissa's first bit is implied
      .put(4, 4)
      .put(0, 2)
      .put(32, 2)
      .put(23, 1)  // exponent: first bit, bits
      .put(8, 1)
      .put(0, 1)  // mantissa
      .put(23, 1)
      .put(127, 4)
      .str();
}

/// Text with a zero at its end, UTF-8.
std::string stringType(size_t length) {
  return Bytes().put(0x13, 1).put(0x10, 3).put(length, 4).str();
}

/// A header message: type, size, flags, content.
std::string message(int type, const std::string& content) {
  const std::string data = aligned(content);
  return Bytes()
      .put(static_cast<std::uint64_t>(type), 2)
      .put(data.size(), 2)
      .put(0, 4)
      .put(data)
      .str();
}

std::string attribute(const std::string& name, const std::string& value) {
  const std::string type = stringType(value.size() + 1), space = dataspace({});
  Bytes content;
  content.put(1, 2).put(name.size() + 1, 2).put(type.size(), 2).put(space.size(), 2);
  content.put(aligned(name + '\0')).put(aligned(type)).put(aligned(space)).put(value + '\0');
  return message(0x000c, content.str());
}

/// Object header, version 1.
std::string objectHeader(const std::vector<std::string>& messages) {
  std::string all;
  for (const std::string& m : messages) all += m;
  return Bytes()
      .put(1, 2)
      .put(messages.size(), 2)
      .put(1, 4)
      .put(all.size(), 4)
      .fill(16)
      .put(all)
      .str();
}

std::string rawData(const Hdf5Data& data) {
  Bytes bytes;
  for (const double value : data.values) {
    std::uint32_t bits = 0;
    if (data.integers) {
      bits = static_cast<std::uint32_t>(static_cast<std::int32_t>(std::lround(value)));
    } else {
      const auto single = static_cast<float>(value);
      static_assert(sizeof bits == sizeof single, "IEEE 754");
      std::memcpy(&bits, &single, sizeof single);
    }
    bytes.put(bits, 4);
  }
  return bytes.str();
}

struct Symbol {
  std::string name;
  Address header;
};

class File {
 public:
  std::string bytes(const Hdf5Group& root) {
    content_.fill(superblockSize);
    const Placed placed = add(root);
    Bytes superblock;
    superblock.put("\x89HDF\r\n\x1a\n").put(0, 5).put(8, 1).put(8, 1).put(0, 1);
    superblock.put(leafK, 2).put(internalK, 2).put(0, 4);
    superblock.put(0, 8).put(undefined, 8).put(content_.size(), 8).put(undefined, 8);
    superblock.put(0, 8)
        .put(placed.header, 8)
        .put(1, 4)
        .put(0, 4)
        .put(placed.tree, 8)
        .put(placed.heap, 8);
    return superblock.str() + content_.str().substr(superblockSize);
  }

 private:
  struct Placed {
    Address header, tree, heap;
  };

  Address append(const std::string& structure) {
    const Address at = content_.align().size();
    content_.put(structure);
    return at;
  }

  Address add(const Hdf5Data& data) {
    const std::string raw = rawData(data);
    const Address at = raw.empty() ? undefined : append(raw);
    const std::string defaultFill = Bytes().put(2, 1).put(2, 1).put(2, 1).put(1, 1).put(0, 4).str();
    return append(objectHeader(
        {message(0x0001, dataspace(data.extents)),
         message(0x0003, data.integers ? integerType() : floatType()), message(0x0005, defaultFill),
         message(0x0008, Bytes().put(3, 1).put(1, 1).put(at, 8).put(raw.size(), 8).str())}));
  }

  Placed add(const Hdf5Group& group) {
    std::vector<Symbol> symbols;
    for (const Hdf5Group& inner : group.groups) symbols.push_back({inner.name, add(inner).header});
    for (const Hdf5Data& data : group.data) symbols.push_back({data.name, add(data)});
    assert(symbols.size() <= 2 * leafK);
    std::sort(symbols.begin(), symbols.end(),
              [](const Symbol& a, const Symbol& b) { return a.name < b.name; });

    Bytes names;  // of the local heap: the empty name first
    names.fill(8);
    Bytes node;
    node.put("SNOD").put(1, 2).put(symbols.size(), 2);
    size_t last = 0;
    for (const Symbol& symbol : symbols) {
      last = names.size();
      node.put(last, 8).put(symbol.header, 8).put(0, 8).put(0, 8).put(0, 8);
      names.put(symbol.name + '\0').align();
    }
    node.fill(8 + 2 * leafK * 40);
    const Address nodeAt = append(node.str());
    const Address namesAt = append(names.str());
    const Address heap =
        append(Bytes().put("HEAP").put(0, 4).put(names.size(), 8).put(1, 8).put(namesAt, 8).str());
    Bytes tree;
    tree.put("TREE").put(0, 2).put(symbols.empty() ? 0 : 1, 2).put(undefined, 8).put(undefined, 8);
    if (!symbols.empty()) tree.put(0, 8).put(nodeAt, 8).put(last, 8);
    tree.fill(24 + (4 * internalK + 1) * 8);
    const Address treeAt = append(tree.str());

    std::vector<std::string> messages = {
        message(0x0011, Bytes().put(treeAt, 8).put(heap, 8).str())};
    for (const auto& [name, value] : group.attributes) messages.push_back(attribute(name, value));
    return {append(objectHeader(messages)), treeAt, heap};
  }

  Bytes content_;
};

}  // namespace

std::string hdf5File(const Hdf5Group& root) { return File().bytes(root); }

}  // namespace sphere_propagation
