/* Control periods of N environments: controller, actuators, physics, sensors, errors and reward. */

static inline int prp_finite(const double *values, long count)
{
    int finite = 1;
    for (long i = 0; i < count; i++)
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
    else {
        prp_refer(
            plan->clock + row, &plan->period, plan->reference_numbers + PRP_REFERENCE_NUMBERS * row, reference);
        for (int i = 0; i < PRP_REFERENCE; i++)
            reference[i] += 0.0; /* no negative zeros, see `Task.reference` */
    }
#endif
}

/* Let the controller choose the action of one environment. */
static inline void prp_control(const prp_plan *plan, long row)
{
    double after[PRP_LARGEST_STATE], *state = plan->state + plan->state_size * row;
    plan->controller(
        plan->observation + PRP_OBSERVED * row, state, plan->input + plan->input_size * row,
        plan->controller_numbers + plan->numbers_size * row, plan->action + PRP_JOINTS * row, after);
    memcpy(state, after, sizeof(double) * plan->state_size);
}

/* What comes before the physics in a period of one environment: from its action to the torques.

   at: row of the period and environment in what is given for every period. */
static inline void prp_before(const prp_plan *plan, long row, long at)
{
    static const double none[PRP_JOINTS];
    double *memory = plan->memory + PRP_MEMORY * row, *torque = plan->torque + PRP_JOINTS * row;
    double after[PRP_MEMORY + 1];
    prp_actuate(
        plan->action + PRP_JOINTS * row, plan->noise ? plan->noise + PRP_JOINTS * at : none, memory,
        plan->task_numbers, plan->command + PRP_JOINTS * row, torque, plan->saturated + PRP_JOINTS * row, after);
    memcpy(memory, after, sizeof(double) * PRP_MEMORY);
    memcpy(plan->applied + PRP_JOINTS * row, torque, sizeof(double) * PRP_JOINTS);
}

/* What comes after the physics: from the measurement to observation, reward and info. */
static inline void prp_after(const prp_plan *plan, long row, long at)
{
    static const double none[3];
    double *memory = plan->memory + PRP_MEMORY * row, after[PRP_MEMORY + 1];
    const double ended = plan->lost[row];
    double truncated;
    plan->clock[row] += 1.0;
    prp_refer_at(plan, row, at);
    prp_judge(
        plan->measured + PRP_MEASURED * row, plan->reference + PRP_REFERENCE * row,
        plan->command + PRP_JOINTS * row, plan->saturated + PRP_JOINTS * row, plan->clock + row,
        plan->beyond + PRP_JOINTS * row, &ended, plan->error ? plan->error + 3 * at : none, memory,
        plan->task_numbers, plan->ground_truth + PRP_GROUND_TRUTH * row, plan->observation + PRP_OBSERVED * row,
        plan->reward + row, plan->info + PRP_INFO * row, &truncated, after);
    plan->truncated[row] = truncated != 0.0;
    memcpy(memory, after, sizeof(double) * PRP_MEMORY);
}

/* Add the results of the last period, the k-th from 0, to those of a step over several periods. */
static inline void prp_add_up(const prp_plan *plan, long row, long k)
{
    const double *info = plan->info + PRP_INFO * row, reward = plan->reward[row] * plan->shares[PRP_INFO];
    double *sums = plan->step_info + PRP_INFO * row;
    plan->step_reward[row] = k ? plan->step_reward[row] + reward : reward;
    for (int i = 0; i < PRP_INFO; i++) {
        const double value = info[i] * plan->shares[i];
        sums[i] = k && plan->added[i] != 0.0 ? sums[i] + value : value;
    }
}

/* Record the last period, the k-th from 0; see `EpisodeRecord`. */
static inline void prp_record(const prp_plan *plan, long row, long k)
{
    const double *info = plan->info + PRP_INFO * row;
    double *kept = plan->recorded_info + PRP_INFO * plan->periods * row + k;
    const size_t joints = sizeof(double) * PRP_JOINTS, to = PRP_JOINTS * (plan->periods * row + k);
    prp_record_fields(
        plan->ground_truth + PRP_GROUND_TRUTH * row, plan->periods + 1, k + 1,
        plan->recorded_fields + PRP_GROUND_TRUTH * (plan->periods + 1) * row);
    memcpy(plan->recorded_command + to, plan->command + PRP_JOINTS * row, joints);
    memcpy(plan->recorded_applied + to, plan->applied + PRP_JOINTS * row, joints);
    for (int i = 0; i < PRP_INFO; i++)
        kept[plan->periods * i] = info[i];
}

/* Record the last period, and add its results to those of the episode and of a step over several periods. */
static inline void prp_sum_up(const prp_plan *plan, long row, long k)
{
    if (plan->recorded_fields)
        prp_record(plan, row, k);
    if (plan->total)
        plan->total[row] += plan->reward[row];
    if (plan->shares)
        prp_add_up(plan, row, k);
}

/* Whether all actions are finite. */
int prp_actions_are_finite(const prp_plan *plan)
{
    return prp_finite(plan->action, PRP_JOINTS * plan->rows);
}

/* The first half of the k-th period of all environments, from 0, and the second, where others simulate in
   between. */
void prp_command(const prp_plan *plan, long k)
{
    for (long row = 0; row < plan->rows; row++)
        prp_before(plan, row, k * plan->rows + row);
}

void prp_score(const prp_plan *plan, long k)
{
    for (long row = 0; row < plan->rows; row++) {
        prp_after(plan, row, k * plan->rows + row);
        prp_sum_up(plan, row, k);
    }
}

#if PRP_BEGINS

/* The reference, the ground truth and what is kept, after some of the environments have begun an episode. */
void prp_begin(const prp_plan *plan)
{
    for (long row = 0; row < plan->rows; row++) {
        double *memory = plan->memory + PRP_MEMORY * row, after[PRP_MEMORY + 1];
        prp_refer_at(plan, row, row);
        prp_start(
            plan->measured + PRP_MEASURED * row, plan->reference + PRP_REFERENCE * row, memory, plan->task_numbers,
            plan->ground_truth + PRP_GROUND_TRUTH * row, after);
        memcpy(memory, after, sizeof(double) * PRP_MEMORY);
    }
}
#endif

/* Choose the actions of all environments; whether all of them are finite. */
int prp_decide(const prp_plan *plan)
{
    for (long row = 0; row < plan->rows; row++)
        prp_control(plan, row);
    return prp_actions_are_finite(plan);
}

#if PRP_PHYSICS

/* Periods of some environments, with a controller or with the actions that are given; see `PLAN` of
   period_source.py. Returns whether all of them are within limits at the end.

   ended: the period in which an environment was lost, or whose action was not finite, counted from 1, and
   negative in the second case; 0 for neither. */
int prp_run(long first, long count, const prp_plan *plan)
{
    int inside = 1;
    for (long row = first; row < first + count; row++) {
        int within = !plan->lost[row];
        plan->ended[row] = 0;
        if (plan->waiting && plan->waiting[row])
            continue;
        for (long k = 0; k < plan->periods && !plan->lost[row]; k++) {
            if (plan->controller)
                prp_control(plan, row);
            if (!prp_finite(plan->action + PRP_JOINTS * row, PRP_JOINTS)) {
                plan->ended[row] = -(k + 1);
                break;
            }
            const long at = k * plan->rows + row;
            prp_before(plan, row, at);
            within = prp_advance(
                row, 1, NULL, plan->world, plan->position, plan->velocity, plan->torque, plan->plants, plan->surfaces,
                plan->measured, plan->beyond, plan->lost);
            prp_after(plan, row, at);
            prp_sum_up(plan, row, k);
            if (plan->lost[row])
                plan->ended[row] = k + 1;
        }
        inside &= within;
    }
    return inside;
}

/* One period of a single environment: 0 where its action is not finite, and nothing has changed; else 1, plus 2
   where the environment was lost, plus 4 where the duration of its episode is over. */
int prp_run_one(const prp_plan *plan)
{
    if (!prp_actions_are_finite(plan))
        return 0;
    prp_run(0, 1, plan);
    return 1 + (plan->lost[0] ? 2 : 0) + (plan->truncated[0] ? 4 : 0);
}
#else

/* The same in two halves, where MuJoCo simulates in between; of a simulation that was lost, which NumPy judges,
   nothing is read. */
int prp_command_one(const prp_plan *plan)
{
    if (!prp_actions_are_finite(plan))
        return 0;
    prp_command(plan, 0);
    return 1;
}

int prp_score_one(const prp_plan *plan, const prp_readings *from)
{
    if (!prp_read(from, plan->measured, plan->beyond))
        return 1 + 2;
    prp_score(plan, 0);
    return 1 + (plan->truncated[0] ? 4 : 0);
}
#endif
