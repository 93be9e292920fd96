// SPDX-License-Identifier: GPL-3.0-only
#include "vcg_ext/anchors/anchor_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include "vcg_ext/base/error.h"

namespace sphere_propagation {
namespace {

namespace fs = std::filesystem;

class AnchorFile : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ =
        fs::temp_directory_path() /
        ("anchors_" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string written(const std::string& name, const std::string& text) const {
    const fs::path path = folder_ / fs::u8path(name);
    std::ofstream(path, std::ios::binary) << text;
    return path.u8string();
  }
  AnchorList read(const std::string& name, const std::string& text) const {
    return readAnchors(written(name, text));
  }
  /// What reading it is refused with.
  Finding refusal(const std::string& name, const std::string& text) const {
    try {
      read(name, text);
    } catch (const AnchorError& error) {
      return error.finding();
    }
    ADD_FAILURE() << name << " was read";
    return Finding(Fault::Text);
  }

  fs::path folder_;
};

using Names = std::vector<std::string>;

Names namesOf(const AnchorSet& anchors) {
  Names names;
  for (const auto& [name, point] : anchors) names.push_back(name);
  return names;
}

TEST_F(AnchorFile, ReadsPickPoints) {
  // As QDomDocument of MeshLab writes it.
  const AnchorList list = read("heart_picked_points.pp", R"(<!DOCTYPE PickedPoints>
<PickedPoints>
 <DocumentData>
  <DateTime date="2026-11-28" time="03:50:00"/>
  <User name="me"/>
  <DataFileName name="heart.ply"/>
  <templateName name=""/>
 </DocumentData>
 <point x="1.5" y="-2" z="3e-05" active="1" name="apex &amp; tip"/>
 <point y="2" z="3" x="1" active="1" name="base"/>
 <point x="0" y="0" z="0" active="0" name="valve"/>
</PickedPoints>
)");
  EXPECT_EQ(namesOf(list.anchors), (Names{"apex & tip", "base"}));
  EXPECT_EQ(list.anchors.at("apex & tip"), Vector3(1.5, -2, 3e-5));
  EXPECT_EQ(list.anchors.at("base"), Vector3(1, 2, 3));
  EXPECT_EQ(list.undefined, Names{"valve"});
}

TEST_F(AnchorFile, ReadsMarkupsOfSlicerInRas) {
  const std::string point = R"({"id": "1", "label": "apex", "description": "",
    "position": [1.0, 2.0, -3.5], "orientation": [-1.0, -0.0, -0.0, -0.0, -1.0, -0.0, 0.0, 0.0, 1.0],
    "selected": true, "positionStatus": "defined"})";
  const std::string missing =
      R"({"id": "2", "label": "base", "position": "", "positionStatus": "undefined"})";
  const auto file = [&](const std::string& system) {
    return R"({"@schema": "https://raw.githubusercontent.com/x/markups-schema-v1.0.3.json#",
      "markups": [{"type": "Fiducial", )" +
           system + R"("coordinateUnits": "mm",
      "controlPoints": [)" +
           point + ", " + missing + "]}]}";
  };
  for (const char* lps : {R"("coordinateSystem": "LPS", )", R"("coordinateSystem": "1", )",
                          R"("coordinateSystem": 1, )", ""}) {
    const AnchorList list = read("a.mrk.json", file(lps));
    EXPECT_EQ(list.anchors, (AnchorSet{{"apex", Vector3(-1, -2, -3.5)}})) << lps;
    EXPECT_TRUE(list.fromLps);
    EXPECT_EQ(list.undefined, Names{"base"});
  }
  for (const char* ras : {R"("coordinateSystem": "RAS", )", R"("coordinateSystem": 0, )"})
    EXPECT_EQ(read("a.json", file(ras)).anchors, (AnchorSet{{"apex", Vector3(1, 2, -3.5)}})) << ras;
  // Of lists in both frames not all can be turned round again.
  const std::string list = R"({"coordinateSystem": ")", points = R"(", "controlPoints": [)";
  const auto both = [&](const std::string& first, const std::string& second) {
    return R"({"markups": [)" + list + first + points + point + "]}, " + list + second + points +
           "]}]}";
  };
  EXPECT_FALSE(read("a.json", both("LPS", "RAS")).fromLps);
  EXPECT_FALSE(read("a.json", both("RAS", "LPS")).fromLps);
  EXPECT_TRUE(read("a.json", both("LPS", "LPS")).fromLps);
  const Finding frame = refusal("a.mrk.json", file(R"("coordinateSystem": "IJK", )"));
  EXPECT_EQ(frame.fault, Fault::AnchorFrame);
  EXPECT_EQ(frame.other, "IJK");
}

TEST_F(AnchorFile, TakesAPointThatIsNotDefinedForMissingWhateverItsPlace) {
  const AnchorList list = read("a.mrk.json", R"({"markups": [{"coordinateSystem": "RAS",
    "controlPoints": [{"label": "a", "position": [0, 0, 0], "positionStatus": "missing"},
                      {"label": "b", "position": [0, 0, 0], "positionStatus": "preview"},
                      {"label": "c"},
                      {"label": "", "position": [7, 8, 9]}]}]})");
  EXPECT_EQ(list.undefined, (Names{"a", "b", "c"}));
  EXPECT_EQ(list.anchors, (AnchorSet{{"4", Vector3(7, 8, 9)}}));
}

TEST_F(AnchorFile, ReadsFiducialsOfSlicer) {
  const std::string header = "# Markups fiducial file version = 5.0\n";
  const std::string columns =
      "# columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID\n";
  const std::string points =
      "1,1.25,2,3,0,0,0,1,1,1,0,apex,,,2,0\n"
      "2,4,5,6,0,0,0,1,1,1,0,\"left, lower\",,,2,0\n"
      "3,0,0,0,0,0,0,1,1,1,0,base,,,0,0\n";
  for (const char* lps : {"LPS", "1"}) {
    const AnchorList list =
        read("a.fcsv", header + "# CoordinateSystem = " + lps + "\n" + columns + points);
    EXPECT_EQ(list.anchors,
              (AnchorSet{{"apex", Vector3(-1.25, -2, 3)}, {"left, lower", Vector3(-4, -5, 6)}}));
    EXPECT_EQ(list.undefined, Names{"base"});
  }
  for (const char* ras : {"# CoordinateSystem = RAS\n", "# CoordinateSystem = 0\r\n", ""})
    EXPECT_EQ(read("a.fcsv", header + ras + columns + points).anchors.at("apex"),
              Vector3(1.25, 2, 3));
  // Slicer 3 had neither version nor columns.
  EXPECT_EQ(read("old.fcsv", "apex,1,2,3,1,1\n").anchors, (AnchorSet{{"apex", Vector3(1, 2, 3)}}));
}

TEST_F(AnchorFile, ReadsLandmarksOfScalismo) {
  const AnchorList list = read("a.json", R"([{"id":"apex","coordinates":[1.5,2.0,-3.25],
    "uncertainty":{"stddevs":[1,1,1],"pcvectors":[[1,0,0],[0,1,0],[0,0,1]]}},
    {"coordinates":[4,5,6],"description":"of the valve","id":"base",
     "extensions":{"of.a.viewer":{"color":null,"visible":false}}}])");
  EXPECT_EQ(list.anchors,
            (AnchorSet{{"apex", Vector3(1.5, 2, -3.25)}, {"base", Vector3(4, 5, 6)}}));
}

TEST_F(AnchorFile, ReadsTables) {
  const AnchorSet both{{"apex", Vector3(1, -2.5, 3)}, {"left base", Vector3(4, 5, 6e-1)}};
  for (const char* text : {
           "name,x,y,z\napex,1,-2.5,3\nleft base,4,5,6e-1\n",
           "apex,1,-2.5,3\nleft base,4,5,0.6",
           "\xEF\xBB\xBFx;y;z;Label\r\n1;-2.5;3;apex\r\n\r\n4;5;.6;\"left base\"\r\n",
           "# made by hand\napex 1 -2.5 3\nleft base\t4 5 0.6\n",
           "name\tx\ty\tz\tnote\napex\t1\t-2.5\t+3\tx\nleft base\t4\t5\t0.6\t\n",
           "\"\",\"X\",\"Y\",\"Z\"\n\"apex\",1,-2.5,3\n\"left base\",4,5,0.6\n",  // R
           "point,x,y,z\napex,1,-2.5,3\nleft base,4,5,0.6\n",
       })
    EXPECT_EQ(read("a.csv", text).anchors, both) << text;
  const AnchorList gaps = read("a.txt", "name,x,y,z\napex,,,\nbase,nan,nan,nan\ntip,1,2,3\n");
  EXPECT_EQ(gaps.undefined, (Names{"apex", "base"}));
  EXPECT_EQ(gaps.anchors, (AnchorSet{{"tip", Vector3(1, 2, 3)}}));
}

TEST_F(AnchorFile, CallsPlacesWithoutNamesByTheirOrder) {
  const AnchorSet three{{"1", Vector3(1, 2, 3)}, {"2", Vector3(4, 5, 6)}, {"3", Vector3(7, 8, 9)}};
  EXPECT_EQ(read("a.particles", "1 2 3\n4.0 5 6\n 7  8 9 \n").anchors, three);
  EXPECT_EQ(read("a.csv", "1,2,3\n4,5,6\n7,8,9\n").anchors, three);
  EXPECT_EQ(read("a.csv", "x,y,z\n1,2,3\n4,5,6\n7,8,9\n").anchors, three);
  EXPECT_EQ(read("a.csv", "x,y,z,note\n1,2,3,a\n4,5,6,b\n7,8,9,c\n").anchors, three);
}

TEST_F(AnchorFile, AnchorsThatStandTwiceAreNone) {
  const AnchorList list = read("a.csv", "a,1,2,3\nb,1,1,1\na,4,5,6\na,1,2,3\nb,1,1,1\n");
  EXPECT_EQ(list.anchors, (AnchorSet{{"b", Vector3(1, 1, 1)}}));
  EXPECT_EQ(list.ambiguous, Names{"a"});
}

TEST_F(AnchorFile, SaysWhatIsWrongAndWhere) {
  EXPECT_EQ(refusal("a.ply", "").fault, Fault::AnchorFileUnknown);
  EXPECT_EQ(refusal("a", "").fault, Fault::AnchorFileUnknown);
  EXPECT_THROW(readAnchors((folder_ / "none.csv").u8string()), AnchorError);
  EXPECT_THROW(readAnchors(folder_.u8string() + ".csv"), AnchorError);
  for (const char* none : {"", "# a comment\n", "name,x,y,z\n"})
    EXPECT_EQ(refusal("a.csv", none).fault, Fault::NoAnchors) << none;
  EXPECT_THROW(readSpherePlaces(written("a.csv", "name,lon,lat\n")), AnchorError);
  const Finding json = refusal("a.json", "[\n{\"id\": \"a\",,}\n]");
  EXPECT_EQ(json.fault, Fault::AnchorFileSyntax);
  EXPECT_EQ(json.first, 2);
  const Finding xml = refusal("a.pp", "<PickedPoints>\n<point x=1/>\n</PickedPoints>");
  EXPECT_EQ(xml.fault, Fault::AnchorFileSyntax);
  EXPECT_EQ(xml.first, 2);
  EXPECT_EQ(refusal("a.pp", "<html/>").fault, Fault::NoAnchors);
  EXPECT_EQ(refusal("a.json", "{\"points\": []}").fault, Fault::NoAnchors);
  EXPECT_EQ(refusal("a.json", "[1, 2, 3]").fault, Fault::NoAnchors);
  for (const char* text :
       {"name,x,y,z\na,1,2,3\nb,1,zwei,3\n", "a,1,2,3\nb,1,2,3\nc,1,2\n", "1 2 3\n4 5 6\n7 8\n"}) {
    const Finding number = refusal("a.csv", text);
    EXPECT_EQ(number.fault, Fault::AnchorNotNumbers) << text;
    EXPECT_EQ(number.detail, "line 3") << text;
  }
  const Finding point =
      refusal("a.pp", "<PickedPoints><point name='p' x='1' y='' z='2'/></PickedPoints>");
  EXPECT_EQ(point.fault, Fault::AnchorNotNumbers);
  EXPECT_EQ(point.detail, "point 1");
  EXPECT_EQ(point.other, "p");
}

TEST_F(AnchorFile, IsFoundBesideItsMesh) {
  const std::string mesh = (folder_ / "heart.v2.ply").u8string();
  EXPECT_TRUE(anchorFilesBeside(mesh).empty());
  EXPECT_TRUE(anchorFilesBeside("").empty());
  for (const char* name : {"heart.v2.fcsv", "heart.v2.csv", "heart.v2.json", "heart.csv",
                           "heart.v2.mrk.json", "heart.v2_picked_points.pp"})
    written(name, "");
  std::vector<std::string> names;
  for (const std::string& file : anchorFilesBeside(mesh))
    names.push_back(fs::u8path(file).filename().u8string());
  EXPECT_EQ(names, (Names{"heart.v2_picked_points.pp", "heart.v2.mrk.json", "heart.v2.csv",
                          "heart.v2.fcsv"}));
}

TEST_F(AnchorFile, IsFoundInAFolderByItsName) {
  const std::string folder = folder_.u8string();
  EXPECT_EQ(anchorFilesIn(folder, "heart.ply"), Names{});
  const std::string plain = written("heart.json", ""), exact = written("heart.ply.csv", ""),
                    dotted = written("phase 0.5.txt", "");
  EXPECT_EQ(anchorFilesIn(folder, "heart"), Names{plain});
  EXPECT_EQ(anchorFilesIn(folder, "heart.ply"), (Names{exact, plain}));
  EXPECT_EQ(anchorFilesIn(folder, "phase 0.5"), Names{dotted});
}

TEST_F(AnchorFile, GivesPlacesOnTheSphere) {
  const AnchorList degrees = readSpherePlaces(
      written("a.csv", "name,longitude,latitude\napex,0,-90\nbase,90,0\nside,180,45\nnone,,\n"));
  ASSERT_EQ(degrees.anchors.size(), 3U);
  EXPECT_LT((degrees.anchors.at("apex") - Vector3(0, 0, -1)).norm(), 1e-15);
  EXPECT_LT((degrees.anchors.at("base") - Vector3(0, 1, 0)).norm(), 1e-15);
  EXPECT_LT((degrees.anchors.at("side") - Vector3(-1, 0, 1) / std::sqrt(2.0)).norm(), 1e-15);
  EXPECT_EQ(degrees.undefined, Names{"none"});
  EXPECT_EQ(readSpherePlaces(written("b.tsv", "lat\tname\tlon\n0\ta\t90\n")).anchors.at("a"),
            degrees.anchors.at("base"));
  const AnchorList directions = readSpherePlaces(written("c.csv", "name,x,y,z\nup,0,0,7\n"));
  EXPECT_EQ(directions.anchors.at("up"), Vector3(0, 0, 1));
  EXPECT_THROW(readSpherePlaces(written("d.csv", "name,lon,lat\na,0,91\n")), RangeError);
  EXPECT_THROW(readSpherePlaces(written("e.csv", "name,x,y,z\na,0,0,0\n")), RangeError);
  EXPECT_THROW(readSpherePlaces(written("f.csv", "name,lon,lat\na,east,1\n")), AnchorError);
}

}  // namespace
}  // namespace sphere_propagation
