// SPDX-License-Identifier: GPL-3.0-or-later
// A display of a test's own: Xvfb, drawn by Mesa in software; and programs that run beside a test.
#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "common/core/error.h"
#include "common/core/stopwatch.h"
#include "temporary_folder.h"

namespace pim {

// Looks again and again until `condition` holds; false after `seconds`.
template <class Condition>
bool comes_true(double seconds, Condition condition) {
    const Stopwatch watch;
    while (!condition()) {
        if (watch.seconds() > seconds) return false;
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    return true;
}

// A program beside the test, ended with it.
class Companion {
  public:
    // `inherited`: a file descriptor that only the program keeps open, or -1. `log`: takes what it writes.
    explicit Companion(std::vector<std::string> arguments, int inherited = -1,
                       const std::filesystem::path& log = {}) {
        std::vector<char*> argv;
        for (std::string& argument : arguments) argv.push_back(argument.data());
        argv.push_back(nullptr);
        pid_ = ::fork();
        if (pid_ == 0) {
            ::prctl(PR_SET_PDEATHSIG, SIGTERM);  // also when the test is killed
            if (!log.empty()) write_to(log);
            ::execvp(argv[0], argv.data());
            ::_exit(127);
        }
        if (inherited >= 0) ::close(inherited);
    }
    ~Companion() {
        if (pid_ <= 0) return;
        ::kill(pid_, SIGTERM);
        ::waitpid(pid_, nullptr, 0);
    }
    Companion(const Companion&) = delete;
    Companion& operator=(const Companion&) = delete;

    void signal(int number) const { ::kill(pid_, number); }

    // Its exit code, or minus the signal that ended it; none while it runs on after `seconds`.
    std::optional<int> ends_within(double seconds) {
        int status = 0;
        if (!comes_true(seconds, [&] { return ::waitpid(pid_, &status, WNOHANG) == pid_; })) return {};
        pid_ = -1;
        return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
    }

    // Ends it.
    bool was_not_installed() {
        int status = 0;
        ::kill(pid_, SIGTERM);
        ::waitpid(std::exchange(pid_, -1), &status, 0);
        return WIFEXITED(status) && WEXITSTATUS(status) == 127;
    }

  private:
    static void write_to(const std::filesystem::path& log) {
        const int file = ::open(log.c_str(), O_CREAT | O_TRUNC | O_WRONLY, 0644);
        ::dup2(file, STDOUT_FILENO);
        ::dup2(file, STDERR_FILENO);
        ::close(file);
    }
    pid_t pid_ = -1;
};

struct DisplayOptions {
    std::string screen = "1280x800x24";
    std::vector<std::string> more = {};  // arguments of Xvfb
};

// A virtual monitor; DISPLAY leads to it.
class VirtualDisplay {
  public:
    explicit VirtualDisplay(const DisplayOptions& options) {
        int ends[2];
        if (::pipe(ends) != 0) throw Error("no pipe");
        std::vector<std::string> arguments{"Xvfb",      "-displayfd", std::to_string(ends[1]),
                                           "-screen",   "0",          options.screen,
                                           "-nolisten", "tcp",        "-noreset"};
        arguments.insert(arguments.end(), options.more.begin(), options.more.end());
        server_.emplace(arguments, ends[1]);
        const std::string number = first_line(ends[0]);
        ::close(ends[0]);
        if (number.empty()) {
            installed_ = !server_->was_not_installed();
            return;
        }
        ::setenv("DISPLAY", (":" + number).c_str(), 1);
        ::setenv("LIBGL_ALWAYS_SOFTWARE", "1", 1);
        ::unsetenv("WAYLAND_DISPLAY");
        runs_ = true;
    }
    ~VirtualDisplay() { ::unsetenv("DISPLAY"); }
    VirtualDisplay(const VirtualDisplay&) = delete;
    VirtualDisplay& operator=(const VirtualDisplay&) = delete;

    bool installed() const { return installed_; }
    bool runs() const { return runs_; }

  private:
    // The line that Xvfb writes when it is ready; empty if it ends or takes half a minute.
    static std::string first_line(int descriptor) {
        std::string line;
        char c = 0;
        pollfd request{descriptor, POLLIN, 0};
        while (::poll(&request, 1, 30000) > 0 && ::read(descriptor, &c, 1) == 1 && c != '\n') line += c;
        return c == '\n' ? line : "";
    }
    std::optional<Companion> server_;
    bool installed_ = true, runs_ = false;
};

// Further arguments are the fields of DisplayOptions.
#define START_DISPLAY(display, ...)                                                        \
    const VirtualDisplay display(DisplayOptions{__VA_ARGS__});                             \
    if (!display.installed())                                                              \
        GTEST_SKIP() << "Xvfb is not installed (Debian package xvfb): no window can open"; \
    ASSERT_TRUE(display.runs()) << "Xvfb does not start"

// Minimises windows on that display. It must run before a window opens: one that opens meanwhile can wait for
// ever in GLFW 3.3 for a sign of being visible.
class WindowManager {
  public:
    // `settings`: an rc.xml of openbox; empty: Debian's.
    explicit WindowManager(const std::string& settings = {}) {
        std::vector<std::string> arguments{"openbox", "--sm-disable", "--startup",
                                           "touch " + (folder_ / "ready").string()};
        if (!settings.empty())
            arguments.insert(arguments.end(), {"--config-file", folder_.write("rc.xml", settings)});
        openbox_.emplace(arguments);
        std::optional<int> ended;
        comes_true(30, [&] { return runs() || (ended = openbox_->ends_within(0)); });
        installed_ = ended != 127;
    }
    bool installed() const { return installed_; }
    bool runs() const { return std::filesystem::exists(folder_ / "ready"); }

  private:
    TemporaryFolder folder_;
    std::optional<Companion> openbox_;
    bool installed_ = true;
};

#define START_WINDOW_MANAGER(manager, ...)                                                              \
    const WindowManager manager{__VA_ARGS__};                                                           \
    if (!manager.installed())                                                                           \
        GTEST_SKIP() << "openbox is not installed (Debian package openbox): nothing minimises windows"; \
    ASSERT_TRUE(manager.runs()) << "openbox does not start"

}  // namespace pim
