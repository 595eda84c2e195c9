// Which setting stands behind a PID whose value is one number of the flash.
#pragma once

#include <array>

#include "devices/protocol/binding.h"
#include "firmware_models/md/settings.h"

namespace virtdrive::md485 {

using Setting = std::int32_t md::Settings::*;

inline constexpr auto kSettingRows = std::to_array<protocol::Binding<Setting>>({
    {16, &md::Settings::inv_sign},          {17, &md::Settings::use_limit_sw},
    {18, &md::Settings::inv_sign2},         {19, &md::Settings::inv_alarm},
    {21, &md::Settings::hall_type},         {22, &md::Settings::inv_sign_out},
    {23, &md::Settings::inv_sign_out2},     {24, &md::Settings::zero_vel_ctrl},
    {25, &md::Settings::input_type},        {26, &md::Settings::later_26},
    {28, &md::Settings::stop_status2},      {29, &md::Settings::use_limit_sw2},
    {36, &md::Settings::start_inv_sign},    {37, &md::Settings::run_inv_sign},
    {38, &md::Settings::regeneration},      {40, &md::Settings::limit_stop_cond},
    {41, &md::Settings::tq_limit_sw},       {44, &md::Settings::tq_ctrl},
    {45, &md::Settings::bluetooth},         {46, &md::Settings::use_eposi},
    {57, &md::Settings::max_ss_time},       {78, &md::Settings::ui_com},
    {81, &md::Settings::later_81},          {82, &md::Settings::sync_type},
    {84, &md::Settings::no_modbus},         {92, &md::Settings::later_92},
    {126, &md::Settings::later_126},        {133, &md::Settings::id},
    {135, &md::Settings::baud_code},        {137, &md::Settings::can_bitrate},
    {146, &md::Settings::ccw_phase_offset}, {147, &md::Settings::cw_phase_offset},
    {149, &md::Settings::return_type},      {150, &md::Settings::tq_po},
    {152, &md::Settings::over_modulation},  {153, &md::Settings::slow_start},
    {154, &md::Settings::slow_down},        {155, &md::Settings::tar_vel},
    {156, &md::Settings::enc_ppr},          {157, &md::Settings::low_speed_limit},
    {158, &md::Settings::high_speed_limit}, {160, &md::Settings::pwm_out},
    {162, &md::Settings::dead_zone},        {167, &md::Settings::pv_gain},
    {168, &md::Settings::p_gain},           {169, &md::Settings::i_gain},
    {170, &md::Settings::tq_p_gain},        {171, &md::Settings::in_position},
    {176, &md::Settings::tar_posi_vel},     {177, &md::Settings::tq_i_gain},
    {178, &md::Settings::posi_ss},          {179, &md::Settings::posi_sd},
    {183, &md::Settings::func_type},        {185, &md::Settings::watch_delay},
    {211, &md::Settings::max_load},         {212, &md::Settings::limit_tq},
    {221, &md::Settings::max_rpm},          {223, &md::Settings::min_rpm},
    {231, &md::Settings::posi_min},         {232, &md::Settings::posi_cen},
    {233, &md::Settings::posi_max},
});

}  // namespace virtdrive::md485
