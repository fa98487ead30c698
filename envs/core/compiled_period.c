/* Control periods of N environments: controller, actuators, physics, sensors, errors and reward. */

static inline int prp_finite(const double *values, int count)
{
    int finite = 1;
    for (int i = 0; i < count; i++)
        finite &= isfinite(values[i]);
    return finite;
}

/* The present reference of one environment. */
static inline void prp_refer_at(const prp_plan *plan, long row, long at)
{
    double *reference = plan->reference + PRP_REFERENCE * row;
    if (plan->sampled)
        memcpy(reference, plan->sampled + PRP_REFERENCE * at, sizeof(double) * PRP_REFERENCE);
#if PRP_REFERENCE_NUMBERS
    else
        prp_refer(plan->clock + row, plan->reference_numbers + PRP_REFERENCE_NUMBERS * row, reference);
#endif
}

/* One period of one environment after the action was chosen. Returns whether all is within limits.

   at: row of the period and environment in what is given for every period; to: in what is recorded. */
static inline int prp_period(const prp_plan *plan, long row, long at, long to)
{
    static const double none[PRP_JOINTS + 3];
    double saturated[PRP_JOINTS], transmitted[PRP_MEMORY + 1], judged[PRP_MEMORY + 1];
    double *memory = plan->memory + PRP_MEMORY * row, *torque = plan->torque + PRP_JOINTS * row;
    double *command = plan->command + PRP_JOINTS * to;
    const double *noise = plan->noise ? plan->noise + PRP_JOINTS * at : none;
    const double *error = plan->error ? plan->error + 3 * at : none;
    prp_actuate(
        plan->action + PRP_JOINTS * row, noise, memory, plan->task_numbers, command, torque, saturated,
        transmitted);
    memcpy(plan->applied + PRP_JOINTS * to, torque, sizeof(double) * PRP_JOINTS);
    const int inside = prp_advance(
        row, 1, plan->world, plan->position, plan->velocity, plan->torque, plan->plants, plan->surfaces,
        plan->measured, plan->beyond, plan->lost);
    const double ended = plan->lost[row];
    plan->clock[row] += 1.0;
    prp_refer_at(plan, row, at);
    prp_judge(
        plan->measured + PRP_MEASURED * row, plan->reference + PRP_REFERENCE * row, command, saturated,
        plan->clock + row, plan->beyond + PRP_JOINTS * row, &ended, error, transmitted, plan->task_numbers,
        plan->ground_truth + PRP_GROUND_TRUTH * to, plan->observation + PRP_OBSERVED * row,
        plan->reward + to, plan->info + PRP_INFO * to, judged);
    memcpy(memory, judged, sizeof(double) * PRP_MEMORY);
    return inside;
}

/* Periods of some environments, with a controller or with the actions that are given; see `PLAN` of
   period_source.py. Returns whether all of them are within limits at the end.

   ended: the period in which an environment was lost, or whose action was not finite, counted from 1, and
   negative in the second case; 0 for neither. */
int prp_run(long first, long count, const prp_plan *plan)
{
    double after[PRP_LARGEST_STATE];
    int inside = 1;
    for (long row = first; row < first + count; row++) {
        double *state = plan->state + plan->state_size * row, *action = plan->action + PRP_JOINTS * row;
        int within = !plan->lost[row];
        plan->ended[row] = 0;
        for (long k = 0; k < plan->periods && !plan->lost[row]; k++) {
            if (plan->controller) {
                plan->controller(
                    plan->observation + PRP_OBSERVED * row, state, plan->input + plan->input_size * row,
                    plan->controller_numbers + plan->numbers_size * row, action, after);
                memcpy(state, after, sizeof(double) * plan->state_size);
            }
            if (!prp_finite(action, PRP_JOINTS)) {
                plan->ended[row] = -(k + 1);
                break;
            }
            within = prp_period(plan, row, k * plan->rows + row, plan->record ? row * plan->periods + k : row);
            if (plan->lost[row])
                plan->ended[row] = k + 1;
        }
        inside &= within;
    }
    return inside;
}
