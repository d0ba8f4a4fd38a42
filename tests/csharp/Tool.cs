using System;
using System.Diagnostics;
using System.IO;

// Other programs, whose paths the build gives in the environment.
internal static class Tool {
  // What a program prints, which must succeed.
  internal static byte[] Run(string variable, string arguments, byte[] input = null) {
    using (Process process = Process.Start(new ProcessStartInfo {
      FileName = Environment.GetEnvironmentVariable(variable), Arguments = arguments, UseShellExecute = false,
      RedirectStandardInput = true, RedirectStandardOutput = true
    })) {
      process.StandardInput.BaseStream.Write(input ?? new byte[0], 0, input?.Length ?? 0);
      process.StandardInput.Close();
      var output = new MemoryStream();
      process.StandardOutput.BaseStream.CopyTo(output);
      process.WaitForExit();
      Test.Equal(0, process.ExitCode);
      return output.ToArray();
    }
  }

  internal static string Text(byte[] output) => System.Text.Encoding.UTF8.GetString(output);
}
