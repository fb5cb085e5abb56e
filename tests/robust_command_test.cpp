// The command where its surroundings fail it: streams that cannot be written, signals, links and pipes, names
// that look like patterns.
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "splat/io/image_file.h"
#include "tests/command.h"
#include "tests/sanitizers.h"
#include "tests/temporary_folder.h"

namespace swept {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::content_of;
using test::Outcome;
using test::put;
using test::run_command;
using test::TemporaryFolder;

json ball_scene() {
  return json::parse(R"({
    "swept": 1, "film": {"width": 32, "height": 24}, "frame": 3,
    "camera": {"fov": {"axis": "vertical", "degrees": 40}, "keys": [{"eye": [0, 0, 5], "target": [0, 0, 0]}]},
    "objects": [{"name": "ball", "source": {"generator": "sphere", "points": 100}}]})");
}

class RobustCommand : public ::testing::Test {
 protected:
  void SetUp() override { put(folder_ / "scene.json", ball_scene().dump()); }

  /// Runs `swept` in the test's folder, by the shell.
  Outcome swept(const std::string& line, const std::string& redirection = "") const {
    return run_command("cd '" + folder_ / "" + "' && (" + std::string(SWEPT_COMMAND) + ' ' + line + ' ' +
                       redirection + ')');
  }

  TemporaryFolder folder_;
};

TEST_F(RobustCommand, AnErrorStreamThatCannotBeWrittenLosesNoFrame) {
  for (const std::string redirection : {"2>/dev/full", "2>&-", "2>&- >&- <&-"}) {
    const Outcome outcome = swept("render scene.json -o f.#.exr --frames 1-3 --overwrite", redirection);
    EXPECT_EQ(outcome.exit_code, 0) << redirection << outcome.err;
    for (const char* name : {"f.1.exr", "f.2.exr", "f.3.exr"}) {
      EXPECT_TRUE(read_exr(folder_ / name).ok()) << redirection << name;
      fs::remove(folder_ / name);
    }
  }
  EXPECT_EQ(swept("render none.json -o a.exr", "2>/dev/full").exit_code, 1);
}

TEST_F(RobustCommand, AFrameThatDoesNotFitIsToldBeforeAnythingIsTaken) {
  if (SWEPT_WITH_ASAN) GTEST_SKIP() << "AddressSanitizer maps more than any bound";
  // Either the machine has less, or the bound is less.
  const std::string huge = "--size 65536x65536 --layers normal,motion,coverage,samples,error";
  const Outcome machine = swept("render scene.json -o a.exr --max-memory 200G " + huge);
  EXPECT_EQ(machine.exit_code, 1);
  EXPECT_NE(machine.err.find("scene.json: /film: a frame of 65536 x 65536 px takes 240.0 GiB at least, and "),
            std::string::npos)
      << machine.err;
  EXPECT_NE(machine.err.find("--part I/N"), std::string::npos) << machine.err;
  // 4096 x 4096 px of 20 bytes are 320 MiB.
  const Outcome bound = swept("render scene.json -o a.exr --size 4096x4096 --max-memory 319M");
  EXPECT_EQ(bound.exit_code, 1);
  EXPECT_NE(bound.err.find("takes 320 MiB at least, and --max-memory allows 319 MiB"), std::string::npos)
      << bound.err;
  // So do layers; and a strip is small enough.
  EXPECT_NE(swept("render scene.json -o a.exr --size 2048x2048 --layers normal,motion --max-memory 90M")
                .err.find("takes 192 MiB at least"),
            std::string::npos);
  EXPECT_EQ(swept("render scene.json --size 65536x65536 --part 9/65536 --dry-run").exit_code, 0);
  EXPECT_FALSE(fs::exists(folder_ / "a.exr"));
}

TEST_F(RobustCommand, DataThatCannotBeWrittenIsAFailure) {
  ASSERT_EQ(swept("render scene.json -o a.exr").exit_code, 0);
  for (const char* line : {"info scene.json", "info scene.json --json", "render scene.json --dry-run",
                           "compare a.exr a.exr", "--help", "render --help", "--version"}) {
    for (const char* redirection : {">/dev/full", ">&-"}) {
      const Outcome outcome = swept(line, redirection);
      EXPECT_EQ(outcome.exit_code, 1) << line << redirection;
      EXPECT_NE(outcome.err, "") << line << redirection;
    }
  }
}

TEST_F(RobustCommand, ASignalTakesTheUnfinishedFileAway) {
  for (const int number : {SIGTERM, SIGINT, SIGHUP}) {
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      const std::string scene = folder_ / "scene.json", output = folder_ / "f.####.exr";
      if (std::freopen("/dev/null", "w", stderr) == nullptr) _exit(126);
      signal(number, SIG_DFL);
      execl(SWEPT_COMMAND, SWEPT_COMMAND, "render", scene.c_str(), "-o", output.c_str(), "--frames", "1-1000",
            "--size", "1200x900", "--overwrite", nullptr);
      _exit(127);
    }
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    bool caught = false;
    while (!caught && std::chrono::steady_clock::now() < deadline) {
      for (const std::string& name : folder_.names()) caught |= name.find(".tmp") != name.npos;
      if (!caught) std::this_thread::sleep_for(std::chrono::microseconds(200));
    }
    EXPECT_EQ(kill(child, number), 0);
    int status = 0;
    ASSERT_EQ(waitpid(child, &status, 0), child);
    EXPECT_TRUE(caught);
    EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == number) << status;
    for (const std::string& name : folder_.names()) EXPECT_EQ(name.find(".tmp"), name.npos) << name;
  }
}

TEST_F(RobustCommand, AFileThatMayNotGrowIsAnErrorAndLeavesNothing) {
  const Outcome limited = run_command("cd '" + folder_ / "" + "' && (ulimit -f 1; " + SWEPT_COMMAND +
                                      " render scene.json -o a.exr --size 400x300)");
  EXPECT_EQ(limited.exit_code, 1) << limited.err;
  EXPECT_NE(limited.err.find("a.exr"), std::string::npos) << limited.err;
  EXPECT_EQ(folder_.names(), std::set<std::string>{"scene.json"});
}

TEST_F(RobustCommand, LinksArePutThroughAndPipesRefused) {
  put(folder_ / "real.exr", "old");
  fs::create_symlink("real.exr", folder_ / "link.exr");
  ASSERT_EQ(swept("render scene.json -o link.exr --overwrite").exit_code, 0);
  EXPECT_TRUE(fs::is_symlink(folder_ / "link.exr"));
  EXPECT_TRUE(read_exr(folder_ / "real.exr").ok());

  ASSERT_EQ(mkfifo((folder_ / "pipe.exr").c_str(), 0600), 0);
  const Outcome pipe = swept("render scene.json -o pipe.exr --overwrite");
  EXPECT_EQ(pipe.exit_code, 1);
  EXPECT_NE(pipe.err.find("pipe"), std::string::npos) << pipe.err;
  EXPECT_TRUE(fs::is_fifo(folder_ / "pipe.exr"));

  fs::create_symlink("real.exr", folder_ / "f.1.exr");
  fs::create_symlink("real.exr", folder_ / "f.2.exr");
  const Outcome one = swept("render scene.json -o f.#.exr --frames 1-2 --overwrite");
  EXPECT_EQ(one.exit_code, 1);
  EXPECT_NE(one.err.find("two outputs"), std::string::npos) << one.err;
}

TEST_F(RobustCommand, OnlyPlaceholdersInAFilesNameAreOnes) {
  for (const char* folder : {"a#b", "50%d", "x$F4"}) {
    fs::create_directory(folder_ / folder);
    const std::string quoted = std::string("'") + folder;
    ASSERT_EQ(swept("render scene.json -o " + quoted + "/100%.exr'").exit_code, 0) << folder;
    EXPECT_TRUE(fs::exists(folder_ / (std::string(folder) + "/100%.exr")));
    ASSERT_EQ(swept("render scene.json -o " + quoted + "/f.$F4.exr' --frames 1-2").exit_code, 0) << folder;
    EXPECT_TRUE(fs::exists(folder_ / (std::string(folder) + "/f.0002.exr")));
  }
  EXPECT_EQ(swept("render scene.json -o 100%.exr --frames 1-2").exit_code, 2);
}

TEST_F(RobustCommand, NamesNearTheLimitAreWritten) {
  const std::string longest(251, 'n');
  EXPECT_EQ(swept("render scene.json -o " + longest + ".exr").exit_code, 0);
  EXPECT_EQ(folder_.names(), (std::set<std::string>{"scene.json", longest + ".exr"}));
  EXPECT_EQ(swept("render scene.json -o " + longest + "n.exr").exit_code, 1);
}

TEST_F(RobustCommand, ADifferenceDoesNotReplaceWhatItIsOf) {
  ASSERT_EQ(swept("render scene.json -o a.exr").exit_code, 0);
  ASSERT_EQ(swept("render scene.json -o b.exr --delta 4").exit_code, 0);
  const std::string a = content_of(folder_ / "a.exr"), b = content_of(folder_ / "b.exr");
  fs::create_hard_link(folder_ / "b.exr", folder_ / "again.exr");
  for (const char* name : {"a.exr", "./b.exr", "again.exr"}) {
    const Outcome outcome = swept(std::string("compare a.exr b.exr --difference ") + name);
    EXPECT_EQ(outcome.exit_code, 1) << name;
    EXPECT_NE(outcome.err.find("--difference"), std::string::npos) << outcome.err;
  }
  EXPECT_EQ(content_of(folder_ / "a.exr"), a);
  EXPECT_EQ(content_of(folder_ / "b.exr"), b);
}

TEST_F(RobustCommand, APictureDoesNotReplaceWhatItIsDrawnFrom) {
  put(folder_ / "a.obj", "mtllib a.mtl\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nvt 0 0\nusemtl wood\nf 1/1 2/1 3/1\n");
  put(folder_ / "a.mtl", "newmtl wood\nmap_Kd wood.png\n");
  const std::string first = "render a.obj --draw triangles --size 16x16 -o wall.exr --preview wood.png";
  Image white;
  white.width = white.height = white.film_width = white.film_height = 1;
  white.rgba = {1, 1, 1, 1};
  ASSERT_TRUE(write_png(folder_ / "wood.png", white));
  ASSERT_TRUE(write_exr(folder_ / "cloth.exr", white));
  const std::string wood = content_of(folder_ / "wood.png"), cloth = content_of(folder_ / "cloth.exr");
  for (const char* existing : {" --overwrite", " --skip-existing"}) {
    const Outcome of_material = swept(first + existing);
    EXPECT_EQ(of_material.exit_code, 1);
    EXPECT_NE(of_material.err.find("wood.png: --preview: is read for the picture"), std::string::npos)
        << of_material.err;
    EXPECT_EQ(content_of(folder_ / "wood.png"), wood);
  }
  const Outcome of_option =
      swept("render a.obj --draw triangles --texture cloth.exr --size 16x16 -o ./cloth.exr --overwrite");
  EXPECT_EQ(of_option.exit_code, 1);
  EXPECT_NE(of_option.err.find("--output: is read for the picture"), std::string::npos) << of_option.err;
  EXPECT_EQ(content_of(folder_ / "cloth.exr"), cloth);
}

TEST_F(RobustCommand, AFileWhoseNameIsNotUtf8IsRefusedInWords) {
  put(folder_ / "a\xff.xyz", "0 0 0 0 0 1\n1 0 0 0 0 1\n1 1 0 0 0 1\n");
  const Outcome outcome =
      run_command(SWEPT_COMMAND, {"render", folder_ / "a\xff.xyz", "-o", folder_ / "a.exr"});
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_NE(outcome.err.find(".xyz: its name"), std::string::npos) << outcome.err;
}

TEST_F(RobustCommand, FramesThatAreLostInRoundingAreErrors) {
  const std::string triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  put(folder_ / "w.1.obj", triangle);
  json scene = ball_scene();
  scene["objects"][0]["source"] = {{"sequence", "w.#.obj"}, {"first", 1}, {"last", 1}, {"cycle", true}};
  for (const double frame : {9007199254740992.0, -1e16, 1e300, 1.1e9}) {
    scene["frame"] = frame;
    put(folder_ / "far.json", scene.dump());
    const Outcome outcome = swept("render far.json -o a.exr");
    EXPECT_EQ(outcome.exit_code, 1) << frame;
    EXPECT_NE(outcome.err.find("/frame"), std::string::npos) << outcome.err;
  }
  EXPECT_EQ(swept("render scene.json -o a.exr --frames 2000000000").exit_code, 1);
  scene["frame"] = 1e9;
  put(folder_ / "far.json", scene.dump());
  EXPECT_EQ(swept("render far.json -o a.exr").exit_code, 0);
}

TEST_F(RobustCommand, ExtremeShuttersAreErrorsBeforeTheRender) {
  for (const char* times : {"-1e38,1e38", "0,1e308", "-1e308,0"})
    EXPECT_EQ(swept(std::string("render scene.json -o a.exr --shutter=") + times).exit_code, 2) << times;
  json scene = ball_scene();
  scene["shutter"] = {{"open", 0}, {"close", 1e38}};
  put(folder_ / "long.json", scene.dump());
  const Outcome outcome = swept("render long.json -o a.exr");
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_NE(outcome.err.find("/shutter/close"), std::string::npos) << outcome.err;
}

TEST_F(RobustCommand, ControlCharactersAreShownAndNotObeyed) {
  json scene = ball_scene();
  scene["objects"][0]["name"] = std::string("a\0b\x1b[2J", 7);
  put(folder_ / "scene.json", scene.dump());
  const Outcome info = swept("info scene.json");
  EXPECT_EQ(info.exit_code, 0);
  EXPECT_NE(info.out.find("a\\x00b\\x1b[2J"), std::string::npos) << info.out;
  EXPECT_EQ(info.out.find('\0'), std::string::npos);
  scene["objects"][0]["bad\x1bkey"] = 1;
  put(folder_ / "scene.json", scene.dump());
  EXPECT_EQ(swept("info scene.json").err.find('\x1b'), std::string::npos);
}

TEST_F(RobustCommand, MoreThreadsThanCoresAreNoMatter) {
  const Outcome outcome = swept("render scene.json -o a.exr --threads 1000");
  EXPECT_EQ(outcome.exit_code, 0);
  EXPECT_EQ(outcome.err.find("TBB"), std::string::npos) << outcome.err;
}

TEST_F(RobustCommand, MistypedWordsAreSuggested) {
  EXPECT_NE(swept("rendr scene.json").err.find("Did you mean render?"), std::string::npos);
  EXPECT_NE(swept("render scene.json --outptu a.exr").err.find("Did you mean --output?"), std::string::npos);
  EXPECT_NE(swept("render scene.json -o a.exr --filter-raduis=2").err.find("--filter-radius?"),
            std::string::npos);
  EXPECT_NE(swept("render scene.json --out a.exr").err.find("Did you mean --output?"), std::string::npos);
  EXPECT_NE(swept("render scene.json -o a.exr --fps 23.976").err.find("a fraction such as 24000/1001"),
            std::string::npos);
  EXPECT_NE(swept("info scene.json --jsno").err.find("Did you mean --json?"), std::string::npos);
  EXPECT_EQ(swept("render scene.json --zzzzzz").err.find("Did you mean"), std::string::npos);
  for (const char* help : {"--help", "render --help"}) {
    EXPECT_NE(swept(help).out.find("Examples:"), std::string::npos);
    EXPECT_NE(swept(help).out.find("Exit codes: 0 done"), std::string::npos);
  }
}

TEST_F(RobustCommand, ShellsCompleteCommandsAndOptions) {
  for (const char* shell : {"bash", "zsh"}) {
    const Outcome script = swept(std::string("completion ") + shell);
    ASSERT_EQ(script.exit_code, 0) << script.err;
    EXPECT_NE(script.out.find("--skip-existing"), std::string::npos);
    EXPECT_EQ(script.out.find("study-worker"), std::string::npos);
  }
  put(folder_ / "try.sh",
      swept("completion bash").out +
          "COMP_WORDS=(swept rend); COMP_CWORD=1; _swept; echo ${COMPREPLY[@]}\n"
          "COMP_WORDS=(swept render --overw); COMP_CWORD=2; _swept; echo ${COMPREPLY[@]}\n"
          "COMP_WORDS=(swept info sce); COMP_CWORD=2; _swept; echo ${COMPREPLY[@]}\n");
  EXPECT_EQ(run_command("cd '" + folder_ / "" + "' && bash try.sh").out, "render\n--overwrite\nscene.json\n");
  EXPECT_EQ(swept("completion fish").exit_code, 2);
}

TEST_F(RobustCommand, HalfFloatsAreAnotherPicture) {
  ASSERT_EQ(swept("render scene.json -o a.exr --half").exit_code, 0);
  ASSERT_EQ(swept("render scene.json -o b.exr").exit_code, 0);
  EXPECT_LT(fs::file_size(folder_ / "a.exr"), fs::file_size(folder_ / "b.exr"));
  EXPECT_EQ(swept("compare b.exr a.exr --min-psnr 60").exit_code, 0);
  EXPECT_EQ(swept("render scene.json -o a.exr --half --skip-existing").exit_code, 0);
  EXPECT_EQ(swept("render scene.json -o a.exr --skip-existing").exit_code, 1);
}

TEST_F(RobustCommand, APipeGetsPlainLinesAndALastOne) {
  const Outcome outcome = swept("render scene.json -o f.#.exr --frames 1-2");
  EXPECT_EQ(outcome.err.find('\x1b'), std::string::npos);
  EXPECT_EQ(outcome.err.find('\r'), std::string::npos);
  EXPECT_NE(outcome.err.find("\n2 frames in 0:0"), std::string::npos) << outcome.err;
}

}  // namespace
}  // namespace swept
