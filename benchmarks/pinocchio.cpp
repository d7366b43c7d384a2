// Time per call of Pinocchio's frame Jacobian with forward kinematics, and of that with gravity torques; best of 200 batches of 300 poses.
#include <pinocchio/algorithm/frames.hpp>
#include <pinocchio/algorithm/jacobian.hpp>
#include <pinocchio/algorithm/rnea.hpp>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <vector>

// Read a chain of joints that turn about x, y or z: axis (0, 1, 2), placement (row by row), mass and its centre; then the placement of the tool.
static pinocchio::SE3 placement()
{
    pinocchio::SE3 found;
    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 3; k++) {
            std::cin >> found.rotation()(i, k);
        }
        std::cin >> found.translation()[i];
    }
    return found;
}

int main()
{
    pinocchio::Model model;
    pinocchio::JointIndex last = 0;
    int count;
    std::cin >> count;
    for (int k = 0; k < count; k++) {
        int axis;
        double mass;
        std::cin >> axis;
        const pinocchio::JointModel kinds[] = {pinocchio::JointModelRX(), pinocchio::JointModelRY(), pinocchio::JointModelRZ()};
        last = model.addJoint(last, kinds[axis], placement(), "joint" + std::to_string(k));
        Eigen::Vector3d centre;
        std::cin >> mass >> centre[0] >> centre[1] >> centre[2];
        model.appendBodyToJoint(last, pinocchio::Inertia(mass, centre, Eigen::Matrix3d::Identity()), pinocchio::SE3::Identity());
    }
    const auto tool = model.addFrame(pinocchio::Frame("tool", last, placement(), pinocchio::OP_FRAME));
    pinocchio::Data data(model);
    std::vector<Eigen::VectorXd> poses(300, Eigen::VectorXd::Zero(model.nq));
    for (auto &q : poses) {
        for (int k = 0; k < model.nq; k++) {
            q[k] = 6.0 * std::rand() / RAND_MAX - 3.0;
        }
    }
    Eigen::Matrix<double, 6, Eigen::Dynamic> jacobian(6, model.nv);
    double best[2] = {1.0, 1.0}, sink = 0.0;
    for (int batch = 0; batch < 200; batch++) {
        for (int gravity = 0; gravity < 2; gravity++) {
            const auto start = std::chrono::steady_clock::now();
            for (const auto &q : poses) {
                jacobian.setZero();
                pinocchio::computeFrameJacobian(model, data, q, tool, pinocchio::LOCAL_WORLD_ALIGNED, jacobian);
                sink += jacobian(5, 0);
                if (gravity) {
                    sink += pinocchio::computeGeneralizedGravity(model, data, q)[0];
                }
            }
            const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
            best[gravity] = std::min(best[gravity], taken.count() / 300);
        }
    }
    pinocchio::framesForwardKinematics(model, data, Eigen::VectorXd::Zero(model.nq));
    const auto torques = pinocchio::computeGeneralizedGravity(model, data, Eigen::VectorXd::Zero(model.nq));
    std::printf("%.9g %.9g %.3g %.12g %.12g\n", best[0], best[1], sink, data.oMf[tool].translation()[0], torques[1]);
    return 0;
}
