// Times dynamics algorithms of Pinocchio on one core.
//
//     dynamics NAME=URDF... [--samples N]
//
// Each line of the output is `robot algorithm minimum median`, in us per call, over samples of 0.5 ms or more.
// `measure.py` compiles it.

#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/cholesky.hpp>
#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/joint-configuration.hpp>
#include <pinocchio/algorithm/rnea.hpp>
#include <pinocchio/parsers/urdf.hpp>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <string>
#include <vector>

namespace pin = pinocchio;
using Clock = std::chrono::steady_clock;

/// Prints the times of `call`, us.
template <typename Call> void time_calls(const std::string &robot, const char *name, int samples, Call call) {
    auto seconds = [&](int calls) {
        const auto begin = Clock::now();
        for (int i = 0; i < calls; ++i) call();
        return std::chrono::duration<double>(Clock::now() - begin).count();
    };
    int calls = 1;
    while (seconds(calls) < 5e-4) calls *= 2;
    std::vector<double> times;
    for (int i = 0; i < samples; ++i) times.push_back(1e6 * seconds(calls) / calls);
    std::sort(times.begin(), times.end());
    std::printf("%s %s %.4f %.4f\n", robot.c_str(), name, times.front(), times[times.size() / 2]);
}

int main(int argc, char **argv) {
    int samples = 200;
    std::vector<std::string> robots;
    for (int i = 1; i < argc; ++i) {
        const std::string argument = argv[i];
        if (argument == "--samples" && i + 1 < argc) samples = std::stoi(argv[++i]);
        else robots.push_back(argument);
    }
    for (const std::string &argument : robots) {
        const auto at = argument.find('=');
        const std::string robot = argument.substr(0, at);
        pin::Model model;
        pin::urdf::buildModel(argument.substr(at + 1), pin::JointModelFreeFlyer(), model);
        model.armature.tail(model.nv - 6).setConstant(0.01);
        pin::Data data(model);
        // Angles and velocities of the bench `dynamics`.
        Eigen::VectorXd q = pin::neutral(model), v(model.nv);
        for (int i = 7; i < model.nq; ++i) q[i] = 0.1 + 0.03 * (i - 7);
        for (int i = 0; i < model.nv; ++i) v[i] = 0.2 - 0.01 * i;
        const Eigen::VectorXd other = Eigen::VectorXd::Constant(model.nv, 0.1);
        std::printf("# %s %d\n", robot.c_str(), model.nv);
        time_calls(robot, "rnea", samples, [&] { pin::rnea(model, data, q, v, other); });
        time_calls(robot, "aba-local", samples, [&] { pin::aba(model, data, q, v, other, pin::Convention::LOCAL); });
        time_calls(robot, "aba-world", samples, [&] { pin::aba(model, data, q, v, other, pin::Convention::WORLD); });
        time_calls(robot, "crba_and_factor-local", samples, [&] {
            pin::crba(model, data, q, pin::Convention::LOCAL);
            pin::cholesky::decompose(model, data);
        });
        time_calls(robot, "crba_and_factor-world", samples, [&] {
            pin::crba(model, data, q, pin::Convention::WORLD);
            pin::cholesky::decompose(model, data);
        });
    }
}
