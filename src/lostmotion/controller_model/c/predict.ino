// Predict the error of the tool and find the joint command that removes the part that is known.
#include <lm_core.h>

static lm_input input;
static lm_options options;
static lm_output output;
static lm_command command;

void setup() {
  Serial.begin(115200);
  lm_defaults(&input);
  lm_default_options(&options);
  if (lm_self_test() != 0) {
    Serial.println("self test failed");
  }
}

void loop() {
  // Wanted joint values, in rad or m, go here.
  const int status = lm_compensate(&input, &options, &output, &command);
  if (status == LM_OK || status == LM_SINGULAR) {
    for (int k = 0; k < LM_JOINTS; k++) {
      Serial.print(static_cast<double>(command.q[k]), 6);
      Serial.print(' ');
    }
    Serial.print("95th percentile of the error in mm: ");
    Serial.println(1000.0 * static_cast<double>(output.length95), 4);
  } else {
    Serial.print("status ");
    Serial.println(status);
  }
  delay(1000);
}
