// SPDX-License-Identifier: GPL-3.0-or-later
#include <pim_version.h>

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <iostream>

#include "bake/bake.h"
#include "bake/error_parts.h"
#include "bake/evaluate.h"
#include "bake/fit_samples.h"
#include "bake/info.h"
#include "bake/plan.h"
#include "bake/sweep.h"
#include "common/core/command_line.h"
#include "common/core/error.h"
#include "common/map/baked_scene.h"

namespace {

using namespace pim;
namespace fs = std::filesystem;

struct Arguments {
    CommonOptions common;
    std::string input, part = "1/1";
    std::vector<std::string> other_inputs;
    std::string output;
    uint64_t photons = 0;
    double target_error = 0;
    std::string time_budget;
    bool description = false;
    std::vector<std::string> settings;
    bool overwrite = false, clean = false, json = false;
    EvaluateOptions evaluate;
    Contest contest;
    std::string contestant = "polynomial";
    bool parts = false;
    int count = 5;
    std::string pictures;
    int own_photons = ErrorPartsOptions{}.photons;
    std::vector<std::string> axes;
    std::string geometry;
};

// "degree=2", in place of what the description says.
Setting parse_setting(const std::string& text) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 >= text.size())
        throw UsageError("--set: '" + text + "' must look like KEY=VALUE");
    table_of_setting(text.substr(0, equals));  // throws where there is none
    return {text.substr(0, equals), text.substr(equals + 1)};
}

std::vector<Setting> settings_of(const Arguments& a) {
    std::vector<Setting> settings;
    if (a.target_error > 0) settings.push_back({"target_error", fmt::format("{}", a.target_error)});
    if (!a.time_budget.empty()) settings.push_back({"time_budget", '"' + a.time_budget + '"'});
    if (a.photons) settings.push_back({"photons", std::to_string(a.photons)});
    for (const std::string& text : a.settings) settings.push_back(parse_setting(text));
    return settings;
}

BakeOptions bake_options(const Arguments& a) {
    BakeOptions options;
    if (!a.output.empty()) options.output = a.output;
    options.settings = settings_of(a);
    options.overwrite = a.overwrite;
    options.clean = a.clean;
    char slash = 0, extra = 0;
    std::istringstream part(a.part);
    if (!(part >> options.part >> slash >> options.parts) || slash != '/' || part >> extra ||
        options.part < 1 || options.part > options.parts)
        throw UsageError("--part: '" + a.part + "' is not K/N with 1 <= K <= N");
    return options;
}

void print(const nlohmann::json& value, bool json,
           const std::function<std::string(const nlohmann::json&)>& text) {
    std::cout << (json ? value.dump(2) + "\n" : text(value));
}

using Command = std::function<void(const Arguments&)>;

CLI::App* add_command(CLI::App& app, Arguments& a, Command& chosen, const char* name, const char* what,
                      const char* input, Command command) {
    CLI::App* sub = app.add_subcommand(name, what);
    sub->add_option(input, a.input)->required();
    sub->callback([&chosen, command] { chosen = command; });
    sub->fallthrough();
    return sub;
}

void add_settings(CLI::App* sub, Arguments& a) {
    sub->add_option("--set", a.settings,
                    "KEY=VALUE: a setting of [bake] or [grid], or samples or boxes of every lamp")
        ->allow_extra_args(false);
}

void add_output_options(CLI::App* sub, Arguments& a) {
    sub->add_option("-o,--output", a.output, "the map to write (default: the description's name with .vdb)");
    sub->add_option("--photons", a.photons, "photons per lamp position, in place of the description's")
        ->check(CLI::PositiveNumber);
    add_settings(sub, a);
}

void add_evaluation_options(CLI::App* sub, Arguments& a) {
    sub->add_option("--lights", a.evaluate.lights, "lamp positions")
        ->check(CLI::Range(1, 100000))
        ->capture_default_str();
    sub->add_option("--pixels", a.evaluate.pixels, "pixels per position")
        ->check(CLI::Range(16, 1000000))
        ->capture_default_str();
    sub->add_option("--paths", a.evaluate.paths, "reference paths per pixel")
        ->check(CLI::Range(2, 1 << 20))
        ->capture_default_str();
}

ErrorPartsOptions parts_options(const Arguments& a, const EvaluateOptions& evaluate) {
    ErrorPartsOptions options{.evaluate = evaluate, .photons = a.own_photons, .pictures = {}};
    if (!a.pictures.empty()) options.pictures = a.pictures;
    return options;
}

Contest contest_of(const Arguments& a) {
    Contest contest = a.contest;
    const PhotonMapOptions &photon_map = contest.photon_map, usual;
    if (a.contestant != "photon_map" &&
        (photon_map.photons_per_lamp != usual.photons_per_lamp || photon_map.nearest != usual.nearest ||
         photon_map.gather != usual.gather))
        throw UsageError("--photons, --nearest and --gather need --integrator photon_map");
    if (a.contestant == "photon_map") contest.contestant = Contestant::photon_map;
    if (a.contestant == "whitted") contest.contestant = Contestant::whitted;
    return contest;
}

// Of several maps, a list; what was traced for the first serves the others of its scene.
void print_evaluations(const Arguments& a, const EvaluateOptions& options) {
    Evaluator evaluator(options);
    if (a.other_inputs.empty()) {
        print(evaluator.evaluate(a.input, contest_of(a)), a.json, evaluation_text);
        return;
    }
    std::vector<std::string> maps{a.input};
    maps.insert(maps.end(), a.other_inputs.begin(), a.other_inputs.end());
    for (const std::string& map : maps) read_baked_scene(map, options.geometry);  // mistakes before the work
    nlohmann::json all = nlohmann::json::array();
    for (const std::string& map : maps) {
        nlohmann::json one = evaluator.evaluate(map, contest_of(a));
        one["map"] = map;
        if (!a.json) std::cout << map << ":\n" << evaluation_text(one) << std::flush;
        all.push_back(std::move(one));
    }
    if (a.json) std::cout << all.dump(2) << "\n";
}

SweepOptions sweep_options(const Arguments& a) {
    SweepOptions options;
    for (const std::string& axis : a.axes) options.axes.push_back(parse_axis(axis));
    options.folder = a.output.empty() ? fs::path(a.input).replace_extension(".sweep") : fs::path(a.output);
    options.evaluate = a.evaluate;
    return options;
}

Command parse(CLI::App& app, Arguments& a, int argc, char** argv) {
    Command chosen;
    app.set_version_flag("--version", std::string("bake ") + kVersion);
    app.add_option("--threads", a.common.threads, "threads (default: all cores)")->check(CLI::Range(1, 4096));
    app.add_flag("--quiet", a.common.quiet, "no progress, no messages but errors");
    app.add_option("--log-level", a.common.log_level, "debug, info, warning, error or off");
    app.require_subcommand(1);
    app.fallthrough();

    CLI::App* run = add_command(app, a, chosen, "run", "bake a scene; goes on where an earlier run stopped",
                                "SCENE.toml", [](const Arguments& x) { bake_run(x.input, bake_options(x)); });
    add_output_options(run, a);
    run->add_option("--target-error", a.target_error,
                    "choose cells, photons, lamp positions, boxes and degree for this relrmse")
        ->check(CLI::Range(1e-6, 10.0));
    run->add_option("--time-budget", a.time_budget, "choose them for this time: 90s, 10m, 8h")
        ->check([](const std::string& text) {
            const auto seconds = parse_duration(text);
            return seconds && *seconds > 0 ? std::string()
                                           : "'" + text + "' is no time such as 90s, 10m or 8h";
        });
    run->add_flag("--overwrite", a.overwrite, "begin anew, whatever an earlier run left");
    run->add_flag("--clean", a.clean, "remove the work folder at the end");

    CLI::App* trace =
        add_command(app, a, chosen, "trace", "trace one part of the lamp positions, for a farm", "SCENE.toml",
                    [](const Arguments& x) { bake_trace(x.input, bake_options(x)); });
    add_output_options(trace, a);
    trace->add_option("--part", a.part, "K/N: the K-th of N parts");

    CLI::App* fit = add_command(app, a, chosen, "fit", "fit what has been traced", "SCENE.toml",
                                [](const Arguments& x) { bake_fit(x.input, bake_options(x)); });
    add_output_options(fit, a);

    CLI::App* plan =
        add_command(app, a, chosen, "plan", "what a bake would do and cost", "SCENE.toml",
                    [](const Arguments& x) { print(plan_bake(x.input, settings_of(x)), x.json, plan_text); });
    add_settings(plan, a);
    plan->add_flag("--json", a.json, "as JSON");

    CLI::App* info =
        add_command(app, a, chosen, "info", "what a baked file holds", "FILE.vdb", [](const Arguments& x) {
            if (x.description)
                std::cout << map_description(x.input);
            else
                print(map_info(x.input), x.json, info_text);
        });
    CLI::Option* as_json = info->add_flag("--json", a.json, "as JSON");
    info->add_flag("--description", a.description,
                   "the scene description that was baked, settings chosen by the bake written out")
        ->excludes(as_json);

    CLI::App* evaluate =
        add_command(app, a, chosen, "evaluate", "error at unseen lamp positions against path tracing",
                    "FILE.vdb", [](const Arguments& x) {
                        EvaluateOptions options = x.evaluate;
                        if (!x.geometry.empty()) options.geometry = x.geometry;
                        if (x.parts)
                            print(error_parts(x.input, parts_options(x, options)), x.json, error_parts_text);
                        else
                            print_evaluations(x, options);
                    });
    CLI::Option* others = evaluate->add_option("MORE.vdb", a.other_inputs, "maps of the same scene");
    add_evaluation_options(evaluate, a);
    CLI::Option* integrator =
        evaluate->add_option("--integrator", a.contestant, "what is held against the reference")
            ->check(CLI::IsMember({"polynomial", "photon_map", "whitted"}))
            ->capture_default_str();
    PhotonMapOptions& photon_map = a.contest.photon_map;
    for (CLI::Option* option :
         {evaluate->add_option("--photons", photon_map.photons_per_lamp, "photon_map: photons per lamp")
              ->check(CLI::Range(1, 100000000)),
          evaluate->add_option("--nearest", photon_map.nearest, "photon_map: photons per estimate")
              ->check(CLI::Range(2, 100000)),
          evaluate->add_option("--gather", photon_map.gather, "photon_map: rays of final gathering")
              ->check(CLI::Range(0, 1 << 20))})
        option->capture_default_str()->needs(integrator);
    CLI::Option* parts =
        evaluate->add_flag("--parts", a.parts, "where the error is: noise, polynomial, leak, grid");
    parts->excludes(integrator)->excludes(others);
    evaluate->add_option("--pictures", a.pictures, "a folder for pictures of the parts")->needs(parts);
    evaluate->add_option("--own-photons", a.own_photons, "of a volume of its own, times the bake's")
        ->check(CLI::Range(1, 10000))
        ->capture_default_str()
        ->needs(parts);
    evaluate->add_option("--geometry", a.geometry, "the geometry file, where it has moved");
    evaluate->add_flag("--json", a.json, "as JSON");

    CLI::App* samples = add_command(
        app, a, chosen, "samples", "densities of some patches over all lamp positions, traced and fitted",
        "FILE.vdb",
        [](const Arguments& x) { print(fit_samples(x.input, x.count), x.json, fit_samples_text); });
    samples->add_option("--count", a.count, "patches per lamp and component, the worst first")
        ->check(CLI::Range(1, 1000))
        ->capture_default_str();
    samples->add_flag("--json", a.json, "as JSON");

    CLI::App* sweeping = add_command(
        app, a, chosen, "sweep", "error against settings: bakes and evaluates all combinations", "SCENE.toml",
        [](const Arguments& x) { print(sweep(x.input, sweep_options(x)), x.json, sweep_text); });
    sweeping->add_option("--axis", a.axes, "KEY=a,b,c: a setting and its values; may be repeated")
        ->allow_extra_args(false)
        ->required();
    sweeping->add_option("-o,--output", a.output, "folder of maps and results (default: SCENE.sweep)");
    add_evaluation_options(sweeping, a);
    sweeping->add_flag("--json", a.json, "as JSON");
    app.parse(argc, argv);
    return chosen;
}

// What was meant as a command and is none; empty if there is nothing of the kind.
std::string unknown_command(const CLI::App& app, int argc, char** argv) {
    for (int i = 1; i < argc; ++i) {
        const std::string word = argv[i];
        if (word == "--threads" || word == "--log-level") ++i;  // and its value
        if (word.starts_with('-')) continue;
        const auto commands =
            app.get_subcommands([&](const CLI::App* sub) { return sub->get_name() == word; });
        return commands.empty() ? word : "";
    }
    return "";
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app{"bake: photons for many lamp positions, fitted to a polynomial illumination map"};
    Arguments arguments;
    Command command;
    try {
        command = parse(app, arguments, argc, argv);
    } catch (const CLI::ParseError& e) {
        if (const std::string word = unknown_command(app, argc, argv);
            e.get_exit_code() != 0 && !word.empty()) {
            std::cerr << "'" << word << "' is no command; `bake --help` lists them\n";
            return kExitUsage;
        }
        return app.exit(e) == 0 ? kExitDone : kExitUsage;
    }
    return run_program(arguments.common, [&] { command(arguments); });
}
