// An independent integrator for tests: SUNDIALS CVODE (BDF, dense) on equations that a test writes
// down for itself.
#pragma once

#include <cvode/cvode.h>
#include <functional>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <vector>

#include "core/check.h"

namespace virtdrive {

class Cvode {
 public:
  using Derivative = std::function<void(double t, const double* x, double* dx)>;

  Cvode(std::vector<double> x, Derivative derivative, double relative, double absolute)
      : derivative_(std::move(derivative)) {
    VIRTDRIVE_CHECK(SUNContext_Create(nullptr, &context_) == 0, "SUNDIALS context");
    const auto n = static_cast<sunindextype>(x.size());
    x_ = N_VNew_Serial(n, context_);
    for (sunindextype i = 0; i < n; ++i) NV_Ith_S(x_, i) = x[static_cast<std::size_t>(i)];
    cvode_ = CVodeCreate(CV_BDF, context_);
    matrix_ = SUNDenseMatrix(n, n, context_);
    solver_ = SUNLinSol_Dense(x_, matrix_, context_);
    check(CVodeInit(cvode_, call, 0, x_));
    check(CVodeSetUserData(cvode_, this));
    check(CVodeSStolerances(cvode_, relative, absolute));
    check(CVodeSetLinearSolver(cvode_, solver_, matrix_));
    check(CVodeSetMaxNumSteps(cvode_, 10'000'000));
  }
  Cvode(const Cvode&) = delete;
  Cvode& operator=(const Cvode&) = delete;
  ~Cvode() {
    CVodeFree(&cvode_);
    SUNLinSolFree(solver_);
    SUNMatDestroy(matrix_);
    N_VDestroy(x_);
    SUNContext_Free(&context_);
  }

  /// Up to t exactly. False if the solver gives up.
  bool advance_to(double t) {
    CVodeSetStopTime(cvode_, t);
    double reached = 0;
    return CVode(cvode_, t, x_, &reached, CV_NORMAL) >= 0;
  }
  /// Forgets the history: to be called when an input has changed.
  void restart(double t) { check(CVodeReInit(cvode_, t, x_)); }

  double operator[](int i) const { return NV_Ith_S(x_, i); }

 private:
  static int call(double t, N_Vector x, N_Vector dx, void* self) {
    static_cast<Cvode*>(self)->derivative_(t, NV_DATA_S(x), NV_DATA_S(dx));
    return 0;
  }
  static void check(int flag) { VIRTDRIVE_CHECK(flag >= 0, "CVODE: {}", flag); }

  Derivative derivative_;
  SUNContext context_ = nullptr;
  N_Vector x_ = nullptr;
  SUNMatrix matrix_ = nullptr;
  SUNLinearSolver solver_ = nullptr;
  void* cvode_ = nullptr;
};

}  // namespace virtdrive
